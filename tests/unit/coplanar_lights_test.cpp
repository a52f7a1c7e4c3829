// SPDX-License-Identifier: Apache-2.0
// Which surfaces hold lights; that the light wins is seen by the accuracy suite.
#include "core/coplanar_lights.h"

#include <gtest/gtest.h>

#include "core/light.h"
#include "support/make_plugin.h"
#include "support/shape_cases.h"

namespace brume {
namespace {

using namespace test;

std::unique_ptr<Shape> square(float half, const Transform& t) {
  return makeShape(
      "trianglemesh",
      {points("P", {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}}),
       integers("indices", {0, 1, 2, 0, 2, 3})},
      t);
}

/// A lamp in the plane z = 0, turned, and surfaces around it.
struct Room {
  Transform turned = Transform::rotate(25, Vec3d(1, 2, 3)) * Transform::translate(Vec3d(3, 1, 2));
  std::vector<std::unique_ptr<Shape>> shapes;
  std::unique_ptr<AreaLight> light;
  std::vector<Primitive> primitives;

  Room() {
    const auto at = [&](const Transform& t) { return turned * t; };
    shapes.push_back(square(.5f, at(Transform())));
    shapes.push_back(square(4, at(Transform())));                             // its ceiling
    shapes.push_back(square(4, at(Transform::translate(Vec3d(0, 0, .01)))));  // a plate near it
    shapes.push_back(square(4, at(Transform::rotate(90, Vec3d(1, 0, 0)))));   // cuts through it
    shapes.push_back(square(.5f, at(Transform::translate(Vec3d(8, 0, 0)))));  // elsewhere in it
    AreaLight::FactoryContext context;
    context.shape = shapes[0].get();
    light = make<AreaLight>("diffuse", {}, context);
    for (const auto& s : shapes) primitives.push_back({s.get(), nullptr, nullptr});
    primitives[0].areaLight = light.get();
  }
};

TEST(CoplanarLights, AreInSurfacesOfTheSamePlaneOnly) {
  const Room room;
  const CoplanarLights lights(room.primitives);
  EXPECT_TRUE(lights.mayBeIn(room.primitives[1]));
  for (std::size_t i : {2, 3, 4}) EXPECT_FALSE(lights.mayBeIn(room.primitives[i])) << i;
}

TEST(CoplanarLights, AreFoundFromBothSides) {
  const Room room;
  const CoplanarLights lights(room.primitives);
  for (const float side : {1.f, -1.f}) {
    const auto found = [&](float x, float y) {
      const Vec3 target = room.turned.point(Vec3(x, y, 0)),
                 from = room.turned.point(Vec3(.3f, .2f, 2 * side));
      const Ray ray{from, normalize(target - from)};
      return lights.at(ray, distance(from, target), 1e-4f).has_value();
    };
    EXPECT_TRUE(found(.1f, .3f));
    EXPECT_FALSE(found(.6f, .3f));
  }
}

TEST(CoplanarLights, NoneWithoutLights) {
  Room room;
  room.primitives[0].areaLight = nullptr;
  const CoplanarLights lights(room.primitives);
  for (const Primitive& p : room.primitives) EXPECT_FALSE(lights.mayBeIn(p));
}

}  // namespace
}  // namespace brume
