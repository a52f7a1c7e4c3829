// SPDX-License-Identifier: Apache-2.0
#include "core/quadric.h"

namespace brume {

namespace {

/// Both roots of a t^2 + b t + c = 0 without cancellation, ascending.
std::array<double, 2> quadraticRoots(double a, double b, double c) {
  const double discriminant = b * b - 4 * a * c;
  if (!(discriminant >= 0))
    return {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
  const double t0 = q / a, t1 = q != 0 ? c / q : t0;
  return t0 < t1 ? std::array{t0, t1} : std::array{t1, t0};
}

/// Derivatives of the unit normal by the equations of Weingarten; zero where the parameters are
/// degenerate.
void setNormalDerivatives(const Vec3d& dpdu, const Vec3d& dpdv, const Vec3d& duu, const Vec3d& duv,
                          const Vec3d& dvv, const Vec3d& n, SurfaceDerivatives& out) {
  const double E = dot(dpdu, dpdu), F = dot(dpdu, dpdv), G = dot(dpdv, dpdv);
  const double e = dot(n, duu), f = dot(n, duv), g = dot(n, dvv);
  const double determinant = E * G - F * F;
  if (!(determinant > 0)) return;
  out.dndu = Vec3((dpdu * (f * F - e * G) + dpdv * (e * F - f * E)) / determinant);
  out.dndv = Vec3((dpdu * (g * F - f * G) + dpdv * (f * F - g * E)) / determinant);
}

}  // namespace

Quadric::Quadric(const FactoryContext& context, const Profile& profile, double phiMaxDegrees)
    : objectToShape_(context.objectToShape),
      volumeRatio_(std::abs(glm::determinant(glm::dmat3(context.objectToShape.matrix())))),
      reverseOrientation_(context.reverseOrientation),
      profile_(profile),
      phiMax_(phiMaxDegrees / 360 * kTwoPi) {}

void Quadric::setExtent(const Extent& extent, const SourceLocation& where) {
  // Box of the transformed box, widened by the rounding of its corners to float.
  Vec3d lo(std::numeric_limits<double>::infinity()), hi(-lo);
  const Mat4d& m = objectToShape_.matrix();
  for (int i = 0; i < 8; ++i) {
    const Vec3d corner(i & 1 ? extent.hi.x : extent.lo.x, i & 2 ? extent.hi.y : extent.lo.y,
                       i & 4 ? extent.hi.z : extent.lo.z);
    const Vec3d p(m * glm::dvec4(corner, 1));
    for (int k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], p[k]);
      hi[k] = std::max(hi[k], p[k]);
    }
  }
  for (int k = 0; k < 3; ++k) {
    constexpr double kLargestCoordinate = 1.8e18;  // Embree drops what lies beyond
    if (!(std::max(-lo[k], hi[k]) <= kLargestCoordinate))
      throw SceneError(where, "the shape reaches beyond a distance of 1.8e18");
    const double slack = 4.0 * kMachineEpsilon * std::max(std::abs(lo[k]), std::abs(hi[k]));
    bounds_.lo[k] = static_cast<float>(lo[k] - slack);
    bounds_.hi[k] = static_cast<float>(hi[k] + slack);
  }

  objectArea_ = extent.area;
  if (extent.normal) onlyNormal_ = Vec3(normalToShape(*extent.normal));
  if (extent.normal || isSimilarity())
    onlyPdfArea_ =
        static_cast<float>(1 / (objectArea_ * areaRatio(extent.normal.value_or(Vec3d(0, 0, 1)))));
}

bool Quadric::isSimilarity() const {
  const Mat4d& m = objectToShape_.matrix();
  const glm::dmat3 gram = glm::transpose(glm::dmat3(m)) * glm::dmat3(m);
  const glm::dmat3 difference = gram - glm::dmat3(gram[0][0]);
  double largest = 0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) largest = std::max(largest, std::abs(difference[c][r]));
  return largest <= 1e-12 * gram[0][0];
}

float Quadric::area() const {
  // Mean of the area ratio over the object-space area by the midpoint rule (smooth, and periodic in
  // phi); one cell where the ratio is constant.
  const int cells = onlyPdfArea_ ? 1 : 64;
  const float cell = 1.f / static_cast<float>(cells);
  double sum = 0;
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      const Vec2 u((static_cast<float>(i) + 0.5f) * cell, (static_cast<float>(j) + 0.5f) * cell);
      sum += areaRatio(normal(sampleObject(u)));
    }
  return static_cast<float>(objectArea_ * sum / (cells * cells));
}

Quadric::Roots Quadric::roots(const Vec3d& o, const Vec3d& d) const {
  // Solved from the point of the ray nearest to the middle of the shape: from afar the terms of the
  // discriminant would cancel.
  const Vec3d middle(0, 0, profile_.zMiddle);
  const double shift = dot(middle - o, d) / dot(d, d);
  const Vec3d s = o + d * shift;
  const double a = d.x * d.x + d.y * d.y - profile_.q2 * d.z * d.z;
  const double b = 2 * (s.x * d.x + s.y * d.y) - profile_.slope(s.z) * d.z;
  const double c = s.x * s.x + s.y * s.y - profile_.at(s.z);
  Roots t = quadraticRoots(a, b, c);
  t[0] += shift;
  t[1] += shift;
  return t;
}

Vec3d Quadric::project(const Vec3d& start) const {
  // Newton's steps along the gradient of f = x^2 + y^2 - q(z), which converge also where the ray
  // grazes.
  Vec3d p = start;
  for (int i = 0; i < 3; ++i) {
    const double f = p.x * p.x + p.y * p.y - profile_.at(p.z);
    const Vec3d gradient(2 * p.x, 2 * p.y, -profile_.slope(p.z));
    const double g2 = dot(gradient, gradient);
    if (!(g2 > 0)) break;
    p -= gradient * (f / g2);
  }
  return p;
}

std::optional<ShapeHit> Quadric::intersect(const Ray& ray) const {
  const Vec3d o = toObject(ray.o), d = vectorToObject(Vec3d(ray.d));
  for (double t : roots(o, d)) {
    const float tHit = static_cast<float>(t);
    if (tHit > 0.f && tHit < ray.tMax && exists(o + d * t)) return ShapeHit{tHit, 0, 0, 0};
  }
  return std::nullopt;
}

SurfaceInteraction Quadric::interaction(const Ray& ray, const ShapeHit& hit) const {
  const Vec3d o = toObject(ray.o), d = vectorToObject(Vec3d(ray.d));
  const Vec3d p = project(o + d * static_cast<double>(hit.t));
  const Local at = local(p);
  const Vec3d dpdu = vectorToShape(at.dpdu), dpdv = vectorToShape(at.dpdv);
  const Vec3d n = normalToShape(at.n);

  SurfaceInteraction si;
  si.p = toShape(p, &si.pError);
  si.n = si.ns = Vec3(n);
  si.uv = {std::clamp(static_cast<float>(at.u), 0.f, 1.f),
           std::clamp(static_cast<float>(at.v), 0.f, 1.f)};
  si.geometry.dpdu = Vec3(dpdu);
  si.geometry.dpdv = Vec3(dpdv);
  setNormalDerivatives(dpdu, dpdv, vectorToShape(at.duu), vectorToShape(at.duv),
                       vectorToShape(at.dvv), n, si.geometry);
  si.shading = si.geometry;
  return si;
}

ShapeSample Quadric::sampleAt(const Vec3d& object, const Vec3d& n) const {
  ShapeSample sample;
  sample.p = toShape(object, &sample.pError);
  sample.n = onlyNormal_ ? *onlyNormal_ : Vec3(normalToShape(n));
  return sample;
}

ShapeSample Quadric::sampleArea(Vec2 u) const {
  const Vec3d object = sampleObject(u);
  ShapeSample sample = sampleAt(object, normal(object));
  sample.pdf = pdfArea(sample.p, sample.n);
  return sample;
}

float Quadric::pdfArea(const Vec3&, const Vec3& n) const {
  if (onlyPdfArea_) return *onlyPdfArea_;
  // The area ratio, from the normal in shape space.
  const Vec3d objectNormal = glm::transpose(glm::dmat3(objectToShape_.matrix())) * Vec3d(n);
  const double ratio = volumeRatio_ / length(objectNormal);
  return static_cast<float>(1 / (objectArea_ * ratio));
}

double Quadric::areaRatio(const Vec3d& n) const {
  const Vec3d image = glm::transpose(glm::dmat3(objectToShape_.inverseMatrix())) * n;
  return volumeRatio_ * length(image);
}

bool Quadric::phiExists(double x, double y) const {
  if (phiMax_ >= kTwoPi) return true;
  const double phi = std::atan2(y, x);
  return (phi < 0 ? phi + kTwoPi : phi) <= phiMax_;
}

Quadric::Polar Quadric::polar(const Vec3d& p, double smallestRadius) {
  Polar result;
  const double radius = std::sqrt(p.x * p.x + p.y * p.y);
  result.radius = std::max(radius, smallestRadius);
  if (radius > 0) {
    result.cosPhi = p.x / radius;
    result.sinPhi = p.y / radius;
    result.phi = std::atan2(p.y, p.x);
    if (result.phi < 0) result.phi += kTwoPi;
  }
  return result;
}

Vec3d Quadric::toObject(const Vec3& p) const {
  return Vec3d(objectToShape_.inverseMatrix() * glm::dvec4(Vec3d(p), 1));
}
Vec3d Quadric::vectorToObject(const Vec3d& v) const {
  return glm::dmat3(objectToShape_.inverseMatrix()) * v;
}
Vec3d Quadric::vectorToShape(const Vec3d& v) const {
  return glm::dmat3(objectToShape_.matrix()) * v;
}
Vec3d Quadric::normalToShape(const Vec3d& n) const {
  const Vec3d image = normalize(glm::transpose(glm::dmat3(objectToShape_.inverseMatrix())) * n);
  return reverseOrientation_ ? -image : image;
}

Vec3 Quadric::toShape(const Vec3d& object, Vec3* error) const {
  const Mat4d& m = objectToShape_.matrix();
  const Vec3d exact(m * glm::dvec4(object, 1));
  const Vec3 p(exact);
  for (int i = 0; i < 3; ++i) {
    // One rounding to float; before that some roundings in double, of the terms and of the point.
    constexpr double kDoubleRoundings = 16 * std::numeric_limits<double>::epsilon();
    const double terms = std::abs(m[0][i] * object.x) + std::abs(m[1][i] * object.y) +
                         std::abs(m[2][i] * object.z) + std::abs(m[3][i]);
    (*error)[i] = kMachineEpsilon * std::abs(p[i]) * (1 + 2 * kMachineEpsilon) +
                  static_cast<float>(kDoubleRoundings * terms) + std::numeric_limits<float>::min();
  }
  return p;
}

}  // namespace brume
