// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/registry.h"
#include "core/triangle_mesh.h"

namespace brume {

namespace {

/// A grid of heights over the unit square of x and y, as faceted triangles; x runs fastest, and
/// u = x, v = y. Test: triangle_mesh_test.
class Heightfield final : public TriangleMesh {
 public:
  struct Params {
    std::optional<int> nu, nv;
    std::vector<float> Pz;
    void visit(ParamVisitor& v) {
      v(nu, "nu", {2}, Unit::None, "heights in x; required");
      v(nv, "nv", {2}, Unit::None, "heights in y; required");
      v(Pz, "Pz", kAnyFloat, Unit::Length, "nu times nv heights, x fastest");
    }
  };

  Heightfield(Params params, const FactoryContext& context)
      : TriangleMesh(triangles(params, context), context) {}

 private:
  static MeshData triangles(const Params& params, const FactoryContext& context);
};

MeshData Heightfield::triangles(const Params& params, const FactoryContext& context) {
  if (!params.nu || !params.nv)
    throw SceneError(context.where, "heightfield needs \"integer nu\" and \"integer nv\"");
  const int nu = *params.nu, nv = *params.nv;
  const std::int64_t count = std::int64_t{nu} * nv;
  if (static_cast<std::int64_t>(params.Pz.size()) != count)
    throw SceneError(context.where,
                     fmt::format("heightfield has {} values of \"Pz\", but nu * nv is "
                                 "{}",
                                 params.Pz.size(), count));

  MeshData data;
  const auto points = static_cast<std::size_t>(count);
  data.points.reserve(points + 1);
  data.uvs.reserve(2 * points);
  for (int y = 0; y < nv; ++y)
    for (int x = 0; x < nu; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(nu - 1);
      const float v = static_cast<float>(y) / static_cast<float>(nv - 1);
      data.points.emplace_back(u, v, params.Pz[data.points.size()]);
      data.uvs.insert(data.uvs.end(), {u, v});
    }
  data.indices.reserve(6 * std::size_t(nu - 1) * std::size_t(nv - 1));
  for (int y = 0; y + 1 < nv; ++y)
    for (int x = 0; x + 1 < nu; ++x) {
      const int a = x + y * nu, b = a + 1, c = a + nu, d = c + 1;
      data.indices.insert(data.indices.end(), {a, b, d, a, d, c});
    }
  return data;
}

const RegisterPlugin<Shape, Heightfield> kRegistration{"heightfield", Origin::PbrtV2,
                                                       "heights over the unit square"};

}  // namespace

}  // namespace brume
