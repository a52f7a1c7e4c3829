// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "core/log.h"
#include "core/registry.h"
#include "core/triangle_mesh.h"

namespace brume {

namespace {

/// Half-edge h = 3 f + k goes from corner k of face f to the next corner.
constexpr int kBoundary = -1;
int faceOf(int h) { return h / 3; }
int nextInFace(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
int previousInFace(int h) { return h % 3 == 0 ? h + 2 : h - 1; }

/// A triangle mesh with its connectivity, as it is subdivided. Works on half-edges alone, so that
/// any mesh, manifold or not, comes to an end: what is not a clean pair of half-edges is a
/// boundary.
struct ControlMesh {
  std::vector<int> corners;  // vertex at the start of each half-edge
  std::vector<int> mates;    // the opposite half-edge, or kBoundary
  std::vector<Vec3> points;

  int faceCount() const { return static_cast<int>(corners.size() / 3); }
  int end(int h) const { return corners[nextInFace(h)]; }
};

/// What the rules for a vertex need of its neighbours.
struct Neighbourhood {
  Vec3 ring{0};          // sum of the neighbours along half-edges that start here
  Vec3 boundary{0};      // sum of the neighbours along boundary edges
  int valence = 0;       // half-edges that start here
  int boundaryEnds = 0;  // boundary edges that end here: 0 inside, 2 on a boundary, else a corner
};

/// Pairs the half-edges; returns how many had to become boundaries because more than two faces, or
/// two of opposite orientation, meet there.
int findMates(ControlMesh& mesh) {
  struct Keyed {
    std::uint64_t edge;
    int h;
  };
  std::vector<Keyed> edges(mesh.corners.size());
  for (int h = 0; h < static_cast<int>(edges.size()); ++h) {
    const auto [a, b] = std::minmax({mesh.corners[h], mesh.end(h)});
    edges[h] = {static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint32_t>(b), h};
  }
  std::sort(edges.begin(), edges.end(), [](const Keyed& a, const Keyed& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.h < b.h;
  });

  mesh.mates.assign(mesh.corners.size(), kBoundary);
  int unmatched = 0;
  for (std::size_t i = 0, next; i < edges.size(); i = next) {
    next = i + 1;
    while (next < edges.size() && edges[next].edge == edges[i].edge) ++next;
    const int a = edges[i].h;
    if (next - i == 2 && mesh.corners[a] == mesh.end(edges[i + 1].h) &&
        faceOf(a) != faceOf(edges[i + 1].h)) {
      mesh.mates[a] = edges[i + 1].h;
      mesh.mates[edges[i + 1].h] = a;
    } else if (next - i >= 2) {
      unmatched += static_cast<int>(next - i);
    }
  }
  return unmatched;
}

std::vector<Neighbourhood> neighbourhoods(const ControlMesh& mesh) {
  std::vector<Neighbourhood> result(mesh.points.size());
  for (int h = 0; h < static_cast<int>(mesh.corners.size()); ++h) {
    const int from = mesh.corners[h], to = mesh.end(h);
    result[from].ring += mesh.points[to];
    ++result[from].valence;
    if (mesh.mates[h] != kBoundary) continue;
    result[from].boundary += mesh.points[to];
    result[to].boundary += mesh.points[from];
    ++result[from].boundaryEnds;
    ++result[to].boundaryEnds;
  }
  return result;
}

/// Loop's weight of a neighbour in the even rule (in the form of Warren).
float evenWeight(int valence) {
  return valence == 3 ? 3.f / 16.f : 3.f / (8.f * static_cast<float>(valence));
}
/// Its counterpart for the limit position.
float limitWeight(int valence) {
  return 1.f / (static_cast<float>(valence) + 3.f / (8.f * evenWeight(valence)));
}

/// (1 - sum of weights) p + weighted neighbours; corners and unused points stay.
Vec3 blend(const Vec3& p, const Neighbourhood& at, float ringWeight, float boundaryWeight) {
  if (at.boundaryEnds == 2) return p * (1 - 2 * boundaryWeight) + at.boundary * boundaryWeight;
  if (at.boundaryEnds != 0 || at.valence == 0) return p;
  return p * (1 - static_cast<float>(at.valence) * ringWeight) + at.ring * ringWeight;
}

/// The new point in the middle of the edge of half-edge h.
Vec3 edgePoint(const ControlMesh& mesh, int h) {
  const Vec3 ends = mesh.points[mesh.corners[h]] + mesh.points[mesh.end(h)];
  if (mesh.mates[h] == kBoundary) return ends * 0.5f;
  const Vec3 opposite = mesh.points[mesh.corners[previousInFace(h)]] +
                        mesh.points[mesh.corners[previousInFace(mesh.mates[h])]];
  return ends * 0.375f + opposite * 0.125f;
}

/// One level: face f becomes faces 4f..4f+2, with corner k of f at place k, and the middle 4f+3,
/// whose corner k lies on edge k. (PBRT-v2's order, on which the default uv depend.)
ControlMesh subdivide(const ControlMesh& mesh) {
  const int halfEdges = static_cast<int>(mesh.corners.size());
  ControlMesh fine;
  const auto edgeCount = static_cast<std::size_t>(
      (halfEdges + std::count(mesh.mates.begin(), mesh.mates.end(), kBoundary)) / 2);
  fine.points.reserve(mesh.points.size() + edgeCount + 1);
  const std::vector<Neighbourhood> around = neighbourhoods(mesh);
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    fine.points.push_back(
        blend(mesh.points[i], around[i], evenWeight(std::max(1, around[i].valence)), 1.f / 8.f));

  // One new point per edge, numbered at the half-edge that comes first.
  std::vector<int> middle(mesh.corners.size());
  for (int h = 0; h < halfEdges; ++h) {
    const int mate = mesh.mates[h];
    if (mate != kBoundary && mate < h) {
      middle[h] = middle[mate];
      continue;
    }
    middle[h] = static_cast<int>(fine.points.size());
    fine.points.push_back(edgePoint(mesh, h));
  }

  fine.corners.resize(4 * mesh.corners.size());
  fine.mates.resize(4 * mesh.corners.size());
  const auto child = [](int face, int which, int k) { return 3 * (4 * face + which) + k; };
  for (int f = 0; f < mesh.faceCount(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3, previous = (k + 2) % 3, h = 3 * f + k;
      fine.corners[child(f, k, k)] = mesh.corners[h];
      fine.corners[child(f, k, next)] = middle[h];
      fine.corners[child(f, k, previous)] = middle[3 * f + previous];
      fine.corners[child(f, 3, k)] = middle[h];

      fine.mates[child(f, k, next)] = child(f, 3, previous);
      fine.mates[child(f, 3, previous)] = child(f, k, next);
      const int mate = mesh.mates[h], g = faceOf(mate), m = mate % 3;
      const bool inside = mate != kBoundary;
      fine.mates[child(f, k, k)] = inside ? child(g, (m + 1) % 3, m) : kBoundary;
      fine.mates[child(f, next, k)] = inside ? child(g, m, m) : kBoundary;
    }
  return fine;
}

/// The neighbours of a vertex in order, from half-edge `start` on and against the orientation of
/// the faces; an open fan from one boundary to the other.
void collectRing(const ControlMesh& mesh, int start, std::vector<Vec3>& ring) {
  ring.clear();
  // Go with the orientation until a boundary, or once around.
  int first = start;
  for (int mate = mesh.mates[previousInFace(first)]; mate != kBoundary && mate != start;
       mate = mesh.mates[previousInFace(first)])
    first = mate;
  const bool open = mesh.mates[previousInFace(first)] == kBoundary;
  if (open) ring.push_back(mesh.points[mesh.corners[previousInFace(first)]]);
  for (int h = first;;) {
    ring.push_back(mesh.points[mesh.end(h)]);
    const int mate = mesh.mates[h];
    if (mate == kBoundary) break;
    h = nextInFace(mate);
    if (h == first) break;
  }
}

/// A vector along the normal of the limit surface: cross product of the tangents by Loop's masks.
/// Its side is PBRT-v2's: against the winding of the faces.
Vec3 limitNormal(const Vec3& p, const std::vector<Vec3>& ring, bool onBoundary) {
  const int n = static_cast<int>(ring.size());
  Vec3d s(0), t(0);
  if (!onBoundary) {
    for (int k = 0; k < n; ++k) {
      const double angle = 2 * double{kPi} * k / n;
      s += Vec3d(ring[k] - p) * std::cos(angle);
      t += Vec3d(ring[k] - p) * std::sin(angle);
    }
  } else {
    // Along the boundary, and across it into the surface.
    s = Vec3d(ring[n - 1] - ring[0]);
    const auto at = [&](int k) { return Vec3d(ring[k] - p); };
    if (n == 2) {
      t = at(0) + at(1);
    } else if (n == 3) {
      t = at(1);
    } else if (n == 4) {
      t = at(1) * 2.0 + at(2) * 2.0 - at(0) - at(3);
    } else {
      const double angle = double{kPi} / (n - 1);
      t = (at(0) + at(n - 1)) * -std::sin(angle);
      for (int k = 1; k < n - 1; ++k)
        t += at(k) * ((2 - 2 * std::cos(angle)) * std::sin(k * angle));
    }
    t = -t;  // the ring of a boundary runs the other way round in PBRT-v2's masks
  }
  return tryNormalize(Vec3(cross(s, t))).value_or(Vec3(0));
}

/// Moves all points to the limit surface and gives its normals.
std::vector<Vec3> pushToLimit(ControlMesh& mesh) {
  const std::vector<Neighbourhood> around = neighbourhoods(mesh);
  std::vector<int> someHalfEdge(mesh.points.size(), kBoundary);
  for (int h = 0; h < static_cast<int>(mesh.corners.size()); ++h) someHalfEdge[mesh.corners[h]] = h;

  std::vector<Vec3> normals(mesh.points.size(), Vec3(0));
  std::vector<Vec3> limit(mesh.points.size()), ring;
  limit.reserve(limit.size() + 1);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    limit[i] =
        blend(mesh.points[i], around[i], limitWeight(std::max(1, around[i].valence)), 1.f / 6.f);
    if (someHalfEdge[i] == kBoundary) continue;
    collectRing(mesh, someHalfEdge[i], ring);
    normals[i] = limitNormal(mesh.points[i], ring, around[i].boundaryEnds != 0);
  }
  mesh.points = std::move(limit);
  return normals;
}

/// Loop subdivision surface of a control mesh: `nlevels` subdivisions, then the limit positions and
/// normals. Boundaries are cubic splines (their limit mask is 1/6 4/6 1/6; PBRT-v2 has 1/5 3/5
/// 1/5); vertices where several boundaries meet stay. Source: Loop 1987; Hoppe et al. 1994 (limit
/// masks); Warren 1995 (weights). Test: loopsubdiv_test.
class LoopSubdiv final : public TriangleMesh {
 public:
  enum class Scheme { Loop };
  struct Params {
    int nlevels = 3;
    std::vector<int> indices;
    std::vector<Vec3> P;
    Scheme scheme = Scheme::Loop;
    void visit(ParamVisitor& v) {
      v(nlevels, "nlevels", kNonNegativeInt, Unit::None, "how often each face is cut in four");
      v(indices, "indices", kNonNegativeInt, Unit::None, "three points of each face, from 0");
      v.points(P, "P", "points of the control mesh");
      v(scheme, "scheme", {{"loop", Scheme::Loop}}, "rules of the subdivision");
    }
  };

  LoopSubdiv(Params params, const FactoryContext& context)
      : TriangleMesh(refine(std::move(params), context), context) {}

 private:
  static MeshData refine(Params params, const FactoryContext& context);
};

void checkControlMesh(const LoopSubdiv::Params& params, const SourceLocation& where) {
  if (params.indices.empty()) throw SceneError(where, "loopsubdiv needs \"integer indices\"");
  if (params.P.empty()) throw SceneError(where, "loopsubdiv needs \"point P\"");
  if (params.indices.size() % 3 != 0)
    throw SceneError(where, fmt::format("loopsubdiv: {} indices are not a multiple of 3",
                                        params.indices.size()));
  for (int i : params.indices)
    if (i < 0 || static_cast<std::size_t>(i) >= params.P.size())
      throw SceneError(where,
                       fmt::format("loopsubdiv: index {} is out of range: there are {} points", i,
                                   params.P.size()));

  // The finest mesh must stay addressable and affordable: about 80 bytes per face while it is made.
  constexpr double kMostFaces = 3e7, kBytesPerFace = 80;
  const double faces = static_cast<double>(params.indices.size() / 3) *
                       std::pow(4.0, static_cast<double>(params.nlevels));
  if (faces > kMostFaces)
    throw SceneError(where,
                     fmt::format("loopsubdiv: {} levels make {:.3g} triangles, which would "
                                 "need {:.3g} GB; at most {:.3g} are allowed",
                                 params.nlevels, faces, faces * kBytesPerFace * 1e-9, kMostFaces));
}

MeshData LoopSubdiv::refine(Params params, const FactoryContext& context) {
  checkControlMesh(params, context.where);
  ControlMesh mesh{std::move(params.indices), {}, std::move(params.P)};
  const int unmatched = findMates(mesh);
  if (unmatched > 0 && context.log)
    context.log->warning(context.where,
                         fmt::format("loopsubdiv: {} edges of faces are shared by more than two "
                                     "faces or run the same way in both: they are boundaries",
                                     unmatched));
  for (int level = 0; level < params.nlevels; ++level) mesh = subdivide(mesh);

  MeshData data;
  data.normals = pushToLimit(mesh);
  data.indices = std::move(mesh.corners);
  data.points = std::move(mesh.points);
  return data;
}

const RegisterPlugin<Shape, LoopSubdiv> kRegistration{"loopsubdiv", Origin::PbrtV2,
                                                      "Loop subdivision surface"};

}  // namespace

}  // namespace brume
