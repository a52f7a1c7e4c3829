// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/log.h"
#include "core/registry.h"
#include "core/triangle_mesh.h"

namespace brume {

namespace {

/// Indexed triangles. Without uv every triangle has (0,0), (1,0), (1,1). Shading normals are
/// transformed but not turned to the side of the face. Test: triangle_mesh_test.
class TriangleMeshShape final : public TriangleMesh {
 public:
  struct Params {
    std::vector<int> indices;
    std::vector<Vec3> P, N, S;
    std::vector<float> uv;
    std::optional<FloatSlot> alpha;
    bool discarddegenerateUVs = false;
    void visit(ParamVisitor& v) {
      v(indices, "indices", kNonNegativeInt, Unit::None, "three points of each triangle, from 0");
      v.points(P, "P", "points");
      v.normals(N, "N", "shading normals, one per point");
      v.vectors(S, "S", "shading tangents, one per point");
      v.alias("st", "uv");
      v(uv, "uv", kAnyFloat, Unit::None, "surface parameters, two per point");
      v(alpha, "alpha", kAnyFloat, Unit::None, "the surface is absent where this is exactly 0");
      v(discarddegenerateUVs, "discarddegenerateUVs",
        "drop all uv of a mesh with N when two corners of a triangle share theirs");
    }
  };

  TriangleMeshShape(Params params, const FactoryContext& context)
      : TriangleMesh(dataOf(std::move(params), context), context) {}

 private:
  static MeshData dataOf(Params params, const FactoryContext& context) {
    if (params.indices.empty())
      throw SceneError(context.where, "trianglemesh needs \"integer indices\"");
    if (params.P.empty()) throw SceneError(context.where, "trianglemesh needs \"point P\"");
    const std::size_t needed = 2 * params.P.size();
    if (params.uv.size() > needed && context.log)
      context.log->warning(
          context.where, fmt::format("{} uv values for {} points: the last {} are "
                                     "not used",
                                     params.uv.size(), params.P.size(), params.uv.size() - needed));
    if (!params.uv.empty() && params.uv.size() < needed)
      throw SceneError(context.where, fmt::format("{} uv values for {} points: {} are needed",
                                                  params.uv.size(), params.P.size(), needed));
    if (!params.uv.empty()) params.uv.resize(needed);
    return {std::move(params.indices),  std::move(params.P),  std::move(params.N),
            std::move(params.S),        std::move(params.uv), params.alpha,
            params.discarddegenerateUVs};
  }
};

const RegisterPlugin<Shape, TriangleMeshShape> kRegistration{"trianglemesh", Origin::PbrtV2,
                                                             "indexed triangles"};

}  // namespace

}  // namespace brume
