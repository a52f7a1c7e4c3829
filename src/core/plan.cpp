// SPDX-License-Identifier: Apache-2.0
#include "core/plan.h"

#include <fmt/format.h>

#include "core/triangle_mesh.h"

namespace brume {
namespace {

/// "1 light", "3 lights".
std::string counted(std::size_t n, std::string_view noun) {
  return fmt::format("{} {}{}", n, noun, n == 1 ? "" : "s");
}

void countSurfaces(const Scene& scene, SceneInventory& found) {
  const auto& groups = scene.contents().groups;
  found.groups = groups.size() - 1;
  found.instances = groups.back().instances.size();
  for (const PrimitiveGroup& group : groups)
    for (const Primitive& primitive : group.primitives)
      if (const TriangleMesh* mesh = primitive.shape->mesh()) {
        ++found.meshes;
        found.triangles += mesh->triangleCount();
      } else {
        ++found.quadrics;
      }
}

void countLights(const Scene& scene, SceneInventory& found) {
  for (const auto& light : scene.lights())
    ++(light->power().isBlack() ? found.blackLights
       : light->isInfinite()    ? found.infiniteLights
       : light->isDelta()       ? found.deltaLights
                                : found.areaLights);
}

}  // namespace

SceneInventory takeInventory(const Scene& scene) {
  SceneInventory found;
  countSurfaces(scene, found);
  countLights(scene, found);
  const Scene::Contents& contents = scene.contents();
  found.materials = contents.materials.size();
  for (const auto& material : contents.materials)
    if (material->hasSpecular()) ++found.specularMaterials;
  found.textures = contents.floatTextures.size() + contents.rgbTextures.size();
  found.volumes = contents.volumes.size();
  if (const Volume* volume = scene.volume()) {
    found.mediaScatter = volume->isScattering();
    found.mediaEmit = volume->isEmissive();
  }
  return found;
}

std::vector<std::string> Plan::lines() const {
  std::vector<std::string> result;
  for (const Item& item : items)
    result.push_back(fmt::format("{} {}{}{}", item.isBuilt ? "build" : "skip ", item.what,
                                 item.why.empty() ? "" : ": ", item.why));
  return result;
}

Plan planScene(const SceneInventory& found) {
  Plan plan;
  if (found.meshes + found.quadrics == 0)
    plan.skip("surfaces", "the scene has none");
  else
    plan.build("surfaces",
               fmt::format("{} with {}, {}, {} of {}",
                           fmt::format("{} mesh{}", found.meshes, found.meshes == 1 ? "" : "es"),
                           counted(found.triangles, "triangle"), counted(found.quadrics, "quadric"),
                           counted(found.instances, "instance"), counted(found.groups, "object")));
  if (found.lights() == 0)
    plan.skip("lights", "the scene has none that emits");
  else
    plan.build("lights", fmt::format("{} without extent, {} on surfaces, {} around the scene",
                                     found.deltaLights, found.areaLights, found.infiniteLights));
  if (found.blackLights > 0)
    plan.skip(counted(found.blackLights, "black light"), "nothing is emitted, so none is sampled");
  if (found.volumes == 0)
    plan.skip("media", "the scene has no Volume");
  else
    plan.build("media", fmt::format("{}{}{}", counted(found.volumes, "volume"),
                                    found.mediaScatter ? ", scattering" : ", not scattering",
                                    found.mediaEmit ? ", emitting" : ""));
  if (found.textures == 0)
    plan.skip("ray footprints", "no texture looks at them");
  else
    plan.build("ray footprints", counted(found.textures, "texture"));
  return plan;
}

}  // namespace brume
