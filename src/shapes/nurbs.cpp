// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/registry.h"
#include "core/triangle_mesh.h"

namespace brume {

namespace {

using Vec4d = glm::dvec4;

/// The knots of one direction with the part of the domain that is shown.
struct Direction {
  int count = 0;  // control points
  int order = 0;
  std::vector<double> knots;
  double lo = 0, hi = 0;

  /// The knot span with knots[i] <= t < knots[i+1]; the last one at the end of the domain.
  int span(double t) const {
    const auto first = knots.begin() + order - 1, last = knots.begin() + count;
    auto it = std::upper_bound(first, last + 1, t);
    if (it > last) it = std::lower_bound(first, last, *last);  // at or past the end
    return static_cast<int>(it - knots.begin()) - 1;
  }
};

/// Value and first derivative of a homogeneous spline by de Boor's recurrence; work holds the
/// `order` control points of the span.
struct SplinePoint {
  Vec4d value{0}, slope{0};
};
SplinePoint deBoor(const Direction& d, int span, double t, std::vector<Vec4d>& work) {
  const int degree = d.order - 1;
  SplinePoint result;
  for (int level = 1; level <= degree; ++level) {
    // Before the last blend the two points left span the tangent.
    if (level == degree)
      result.slope = (work[1] - work[0]) * (degree / (d.knots[span + 1] - d.knots[span]));
    for (int j = 0; j <= degree - level; ++j) {
      const double left = d.knots[span - degree + level + j], right = d.knots[span + 1 + j];
      const double a = (t - left) / (right - left);
      work[j] = work[j] * (1 - a) + work[j + 1] * a;
    }
  }
  result.value = work[0];
  return result;
}

struct SurfacePoint {
  Vec3d p{0}, dpdu{0}, dpdv{0};
};

/// Non-uniform rational B-spline surface, cut into triangles that follow it closely: every knot
/// span is divided so that chords stay within 1/5000 of the surface's size (PBRT-v2: 30 x 30 points
/// always, which is also the least here). u and v are the knots' parameters. Source: Piegl, Tiller,
/// The NURBS Book. Test: nurbs_test.
class Nurbs final : public TriangleMesh {
 public:
  struct Params {
    std::optional<int> nu, nv, uorder, vorder;
    std::vector<float> uknots, vknots;
    std::optional<float> u0, u1, v0, v1;
    std::vector<Vec3> P;
    std::vector<float> Pw;
    void visit(ParamVisitor& v) {
      v(nu, "nu", {2}, Unit::None, "control points in u; required");
      v(nv, "nv", {2}, Unit::None, "control points in v; required");
      v(uorder, "uorder", {2, 64}, Unit::None, "degree in u plus 1; required");
      v(vorder, "vorder", {2, 64}, Unit::None, "degree in v plus 1; required");
      v(uknots, "uknots", kAnyFloat, Unit::None, "nu + uorder knots that do not decrease");
      v(vknots, "vknots", kAnyFloat, Unit::None, "nv + vorder knots that do not decrease");
      v(u0, "u0", kAnyFloat, Unit::None, "start in u; the domain's by default");
      v(u1, "u1", kAnyFloat, Unit::None, "end in u; the domain's by default");
      v(v0, "v0", kAnyFloat, Unit::None, "start in v; the domain's by default");
      v(v1, "v1", kAnyFloat, Unit::None, "end in v; the domain's by default");
      v.points(P, "P", "nu * nv control points, u fastest");
      v(Pw, "Pw", kAnyFloat, Unit::None, "instead of P: x y z w of each, already multiplied by w");
    }
  };

  Nurbs(Params params, const FactoryContext& context)
      : TriangleMesh(dice(params, context.where), context) {}

 private:
  static MeshData dice(const Params& params, const SourceLocation& where);
};

/// The control net in homogeneous coordinates.
struct Surface {
  Direction u, v;
  std::vector<Vec4d> points;  // u fastest

  SurfacePoint at(double s, double t) const;
};

SurfacePoint Surface::at(double s, double t) const {
  const int i = u.span(s), j = v.span(t), firstU = i - u.order + 1, firstV = j - v.order + 1;
  std::vector<Vec4d> work, rowValues, rowSlopes;
  for (int row = 0; row < v.order; ++row) {
    const auto begin = points.begin() + std::ptrdiff_t{firstV + row} * u.count + firstU;
    work.assign(begin, begin + u.order);
    const SplinePoint along = deBoor(u, i, s, work);
    rowValues.push_back(along.value);
    rowSlopes.push_back(along.slope);
  }
  const SplinePoint p = deBoor(v, j, t, rowValues);
  const Vec4d du = deBoor(v, j, t, rowSlopes).value;
  const double w = p.value.w;
  SurfacePoint result;
  result.p = Vec3d(p.value) / w;
  result.dpdu = (Vec3d(du) - result.p * du.w) / w;
  result.dpdv = (Vec3d(p.slope) - result.p * p.slope.w) / w;
  return result;
}

Direction makeDirection(std::optional<int> count, std::optional<int> order,
                        const std::vector<float>& knots, std::optional<float> lo,
                        std::optional<float> hi, char name, const SourceLocation& where) {
  if (!count || !order)
    throw SceneError(where,
                     fmt::format("nurbs needs \"integer n{0}\" and \"integer {0}order\"", name));
  if (*count < *order)
    throw SceneError(where, fmt::format("nurbs: n{0} is {1}, but {0}order {2} needs at least {2}",
                                        name, *count, *order));
  const std::int64_t needed = std::int64_t{*count} + *order;
  if (static_cast<std::int64_t>(knots.size()) != needed)
    throw SceneError(where, fmt::format("nurbs: {} values of \"{}knots\", but n{} + {}order is {}",
                                        knots.size(), name, name, name, needed));
  if (!std::is_sorted(knots.begin(), knots.end()))
    throw SceneError(where, fmt::format("nurbs: \"{}knots\" decrease", name));

  Direction d{*count, *order, {knots.begin(), knots.end()}, 0, 0};
  const double first = d.knots[d.order - 1], last = d.knots[d.count];
  if (!(first < last))
    throw SceneError(where, fmt::format("nurbs: \"{}knots\" leave no domain", name));
  d.lo = lo ? double{*lo} : first;
  d.hi = hi ? double{*hi} : last;
  if (d.lo < first || d.hi > last || !(d.lo < d.hi))
    throw SceneError(where, fmt::format("nurbs: {0}0 = {1} to {0}1 = {2} must grow inside the "
                                        "domain {3} to {4}",
                                        name, d.lo, d.hi, first, last));
  return d;
}

Surface makeSurface(const Nurbs::Params& params, const SourceLocation& where) {
  Surface s;
  s.u = makeDirection(params.nu, params.uorder, params.uknots, params.u0, params.u1, 'u', where);
  s.v = makeDirection(params.nv, params.vorder, params.vknots, params.v0, params.v1, 'v', where);
  const std::int64_t needed = std::int64_t{s.u.count} * s.v.count;
  if (params.P.empty() == params.Pw.empty())
    throw SceneError(where, "nurbs needs either \"point P\" or \"float Pw\"");
  if (params.Pw.size() % 4 != 0)
    throw SceneError(
        where, fmt::format("nurbs: {} values of \"Pw\" are not a multiple of 4", params.Pw.size()));
  const std::size_t given = params.P.empty() ? params.Pw.size() / 4 : params.P.size();
  if (static_cast<std::int64_t>(given) != needed)
    throw SceneError(where,
                     fmt::format("nurbs: {} control points, but nu * nv is {}", given, needed));
  for (const Vec3& p : params.P) s.points.emplace_back(p.x, p.y, p.z, 1);
  for (std::size_t i = 0; i < params.Pw.size(); i += 4) {
    if (!(params.Pw[i + 3] > 0.f))
      throw SceneError(where,
                       fmt::format("nurbs: the weight of control point {} is {}, but must be "
                                   "greater than 0",
                                   i / 4, params.Pw[i + 3]));
    s.points.emplace_back(params.Pw[i], params.Pw[i + 1], params.Pw[i + 2], params.Pw[i + 3]);
  }
  return s;
}

/// The shown borders of the knot spans in one direction.
std::vector<double> spanBorders(const Direction& d) {
  std::vector<double> borders{d.lo};
  for (int i = d.order; i < d.count; ++i)
    if (d.knots[i] > borders.back() && d.knots[i] < d.hi) borders.push_back(d.knots[i]);
  borders.push_back(d.hi);
  return borders;
}

/// How often each span must be cut so that a chord stays within `tolerance` of the curve: h^2/8
/// |p''| <= tolerance, the second derivative from differences along some lines across. pointAt(t,
/// across) with across in [0, 1].
template <class PointAt>
std::vector<double> parameters(const Direction& d, double tolerance, const PointAt& pointAt) {
  constexpr int kLines = 9, kProbes = 8, kMostCuts = 64, kLeastCells = 29;
  const std::vector<double> borders = spanBorders(d);
  const int spans = static_cast<int>(borders.size()) - 1;
  const int least = (kLeastCells + spans - 1) / spans;
  std::vector<double> result;
  for (int span = 0; span < spans; ++span) {
    const double lo = borders[span], h = (borders[span + 1] - lo) / kProbes;
    double sag = 0;  // of a chord over one probe interval
    for (int line = 0; line < kLines; ++line)
      for (int i = 1; i < kProbes; ++i) {
        const double across = line / double{kLines - 1};
        const Vec3d bend = pointAt(lo + (i - 1) * h, across) - pointAt(lo + i * h, across) * 2.0 +
                           pointAt(lo + (i + 1) * h, across);
        sag = std::max(sag, length(bend) / 8);
      }
    const double wanted = std::ceil(kProbes * std::sqrt(sag / tolerance));
    const int cuts =
        std::clamp(static_cast<int>(std::min(wanted, 1e6)), least, std::max(least, kMostCuts));
    for (int i = 0; i < cuts; ++i) result.push_back(lo + (borders[span + 1] - lo) * i / cuts);
  }
  result.push_back(d.hi);
  return result;
}

/// Unit normal; where the parameters are degenerate (a pole), that of a point a little inside.
Vec3 normalAt(const Surface& s, double u, double v) {
  constexpr double kInside = 1e-5;
  for (int attempt = 0; attempt < 2; ++attempt) {
    const SurfacePoint at = s.at(u, v);
    const Vec3d n = cross(at.dpdu, at.dpdv);
    const double scale = length(at.dpdu) + length(at.dpdv);
    if (length(n) > 1e-9 * scale * scale) return Vec3(normalize(n));
    u += (0.5 * (s.u.lo + s.u.hi) - u) * kInside;
    v += (0.5 * (s.v.lo + s.v.hi) - v) * kInside;
  }
  return Vec3(0);  // the mesh uses the face's
}

MeshData Nurbs::dice(const Params& params, const SourceLocation& where) {
  const Surface s = makeSurface(params, where);
  Vec3d lo(Vec3d(s.points[0]) / s.points[0].w), hi = lo;
  for (const Vec4d& p : s.points)
    for (int k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], p[k] / p.w);
      hi[k] = std::max(hi[k], p[k] / p.w);
    }
  const double tolerance = std::max(length(hi - lo) / 5000, 1e-300);
  const std::vector<double> us = parameters(s.u, tolerance, [&](double t, double across) {
    return s.at(t, s.v.lo + (s.v.hi - s.v.lo) * across).p;
  });
  const std::vector<double> vs = parameters(s.v, tolerance, [&](double t, double across) {
    return s.at(s.u.lo + (s.u.hi - s.u.lo) * across, t).p;
  });
  const std::size_t count = us.size() * vs.size();
  constexpr std::size_t kMostPoints = 20'000'000;
  if (count > kMostPoints)
    throw SceneError(
        where, fmt::format("nurbs: a grid of {} x {} points would be needed, {:.3g} GB; "
                           "at most {} points are allowed",
                           us.size(), vs.size(), static_cast<double>(count) * 56e-9, kMostPoints));

  MeshData data;
  data.points.reserve(count + 1);
  data.normals.reserve(count);
  data.uvs.reserve(2 * count);
  for (double v : vs)
    for (double u : us) {
      data.points.emplace_back(s.at(u, v).p);
      data.normals.push_back(normalAt(s, u, v));
      data.uvs.insert(data.uvs.end(), {static_cast<float>(u), static_cast<float>(v)});
    }
  const int width = static_cast<int>(us.size()), height = static_cast<int>(vs.size());
  data.indices.reserve(6 * count);
  for (int y = 0; y + 1 < height; ++y)
    for (int x = 0; x + 1 < width; ++x) {
      const int a = x + y * width, b = a + 1, c = a + width, d = c + 1;
      data.indices.insert(data.indices.end(), {a, b, d, a, d, c});
    }
  return data;
}

const RegisterPlugin<Shape, Nurbs> kRegistration{"nurbs", Origin::PbrtV2,
                                                 "rational B-spline surface"};

}  // namespace

}  // namespace brume
