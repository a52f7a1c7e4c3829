// SPDX-License-Identifier: Apache-2.0
#include "core/transform.h"

#include "core/error.h"

namespace brume {

namespace {

using Mat3d = glm::dmat3;

double largestEntry(const Mat3d& m) {
  double largest = 0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) largest = std::max(largest, std::abs(m[c][r]));
  return largest;
}

}  // namespace

Transform::Transform(const Mat4d& m) : m_(m), inverse_(glm::inverse(m)) { updateFloats(); }
Transform::Transform(const Mat4d& m, const Mat4d& inverse) : m_(m), inverse_(inverse) {
  updateFloats();
}

void Transform::updateFloats() {
  f_ = Mat4(m_);
  inverseF_ = Mat4(inverse_);
}

bool Transform::isInvertible(const Mat4d& m) {
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r)
      if (!std::isfinite(m[c][r])) return false;
  // Affine, and the volume of the unit cube not lost to rounding against the longest edge it could
  // have.
  if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] == 0) return false;
  const Mat3d linear(m);
  const double scale = largestEntry(linear);
  if (scale == 0) return false;
  const double relative = std::abs(glm::determinant(linear / scale));
  constexpr double kNegligible = 1e-24;  // scales may differ by 1e12 between two axes
  return relative > kNegligible;
}

Transform Transform::translate(const Vec3d& delta) {
  Mat4d m(1.0), inverse(1.0);
  m[3] = glm::dvec4(delta, 1.0);
  inverse[3] = glm::dvec4(-delta, 1.0);
  return {m, inverse};
}

Transform Transform::scale(double x, double y, double z) {
  Mat4d m(1.0), inverse(1.0);
  m[0][0] = x;
  m[1][1] = y;
  m[2][2] = z;
  inverse[0][0] = 1 / x;
  inverse[1][1] = 1 / y;
  inverse[2][2] = 1 / z;
  return {m, inverse};
}

Transform Transform::rotate(double degrees, const Vec3d& axis) {
  const Vec3d a = normalize(axis);
  const double angle = degrees * (3.14159265358979323846 / 180.0), s = std::sin(angle),
               c = std::cos(angle);
  Mat4d m(1.0);
  // Column j is the image of unit vector j (Rodrigues).
  for (int j = 0; j < 3; ++j) {
    Vec3d e(0);
    e[j] = 1;
    const Vec3d image = e * c + cross(a, e) * s + a * (a[j] * (1 - c));
    m[j] = glm::dvec4(image, 0.0);
  }
  return {m, glm::transpose(m)};
}

std::optional<Transform> Transform::lookAt(const Vec3d& eye, const Vec3d& look, const Vec3d& up) {
  const double distance = length(look - eye), upLength = length(up);
  if (!(distance > 0) || !(upLength > 0) || !std::isfinite(distance) || !std::isfinite(upLength))
    return std::nullopt;
  const Vec3d forward = (look - eye) / distance;
  Vec3d right = cross(up / upLength, forward);
  if (!(length(right) > 1e-12)) return std::nullopt;
  right = normalize(right);
  const Vec3d newUp = cross(forward, right);
  Mat4d cameraToWorld(1.0);
  cameraToWorld[0] = glm::dvec4(right, 0);
  cameraToWorld[1] = glm::dvec4(newUp, 0);
  cameraToWorld[2] = glm::dvec4(forward, 0);
  cameraToWorld[3] = glm::dvec4(eye, 1);
  return Transform(glm::inverse(cameraToWorld), cameraToWorld);
}

Vec3 Transform::point(const Vec3& p) const {
  return Vec3(f_[0] * p.x + f_[1] * p.y + f_[2] * p.z + f_[3]);
}
Vec3 Transform::vector(const Vec3& v) const {
  return Vec3(f_[0] * v.x + f_[1] * v.y + f_[2] * v.z);
}

Vec3 Transform::normal(const Vec3& n) const {
  return {inverseF_[0][0] * n.x + inverseF_[0][1] * n.y + inverseF_[0][2] * n.z,
          inverseF_[1][0] * n.x + inverseF_[1][1] * n.y + inverseF_[1][2] * n.z,
          inverseF_[2][0] * n.x + inverseF_[2][1] * n.y + inverseF_[2][2] * n.z};
}

Vec3 Transform::point(const Vec3& p, const Vec3& pError, Vec3* error) const {
  const Vec3 a = abs(p);
  for (int r = 0; r < 3; ++r) {
    const float carried = std::abs(f_[0][r]) * pError.x + std::abs(f_[1][r]) * pError.y +
                          std::abs(f_[2][r]) * pError.z;
    const float rounded = std::abs(f_[0][r]) * a.x + std::abs(f_[1][r]) * a.y +
                          std::abs(f_[2][r]) * a.z + std::abs(f_[3][r]);
    // Three products and sums, and the rounding of the matrix itself.
    (*error)[r] = (gamma(3) + 1) * carried + gamma(4) * rounded;
  }
  return point(p);
}

Bounds3 Transform::bounds(const Bounds3& b) const {
  if (b.isEmpty()) return b;
  Bounds3 result;
  for (int i = 0; i < 8; ++i) {
    Vec3 error;
    const Vec3 p = point(b.corner(i), Vec3(0), &error);
    result.extend(p - error);
    result.extend(p + error);
  }
  return result;
}

Ray Transform::ray(const Ray& r) const { return {point(r.o), vector(r.d), r.tMax, r.time}; }

bool Transform::swapsHandedness() const { return glm::determinant(Mat3d(m_)) < 0; }

bool Transform::hasScale() const {
  for (int c = 0; c < 3; ++c) {
    const double l2 = dot(Vec3d(m_[c]), Vec3d(m_[c]));
    if (l2 < 0.998 || l2 > 1.002) return true;
  }
  return false;
}

AnimatedTransform::AnimatedTransform(const Transform& start, float t0, const Transform& end,
                                     float t1)
    : start_(start), end_(end), t0_(t0), t1_(t1), animated_(!(start == end) && t0 < t1) {
  if (!animated_) return;
  d0_ = decompose(start.matrix());
  d1_ = decompose(end.matrix());
  // The shorter way round.
  double cosine = 0;
  for (int i = 0; i < 4; ++i) cosine += d0_.rotation[i] * d1_.rotation[i];
  if (cosine < 0)
    for (double& q : d1_.rotation) q = -q;
}

AnimatedTransform::Decomposed AnimatedTransform::decompose(const Mat4d& m) {
  Decomposed result;
  result.translation = Vec3d(m[3]);
  // Polar decomposition by Newton iteration (Shoemake, Duff 1992): linear = rotation * stretch.
  const Mat3d linear(m);
  Mat3d rotation = linear;
  for (int i = 0; i < 100; ++i) {
    const Mat3d next = 0.5 * (rotation + glm::transpose(glm::inverse(rotation)));
    const double change = largestEntry(next - rotation);
    rotation = next;
    if (change < 1e-14) break;
  }
  // A mirroring belongs to the stretch: the rotation must be proper to be a quaternion.
  if (glm::determinant(rotation) < 0) rotation = -rotation;
  result.stretch = Mat4d(glm::transpose(rotation) * linear);

  // Quaternion of the rotation, from its largest component.
  const double trace = rotation[0][0] + rotation[1][1] + rotation[2][2];
  double* q = result.rotation;
  if (trace > 0) {
    const double s = 2 * std::sqrt(trace + 1);
    q[0] = 0.25 * s;
    q[1] = (rotation[1][2] - rotation[2][1]) / s;
    q[2] = (rotation[2][0] - rotation[0][2]) / s;
    q[3] = (rotation[0][1] - rotation[1][0]) / s;
  } else {
    int i = rotation[1][1] > rotation[0][0] ? 1 : 0;
    if (rotation[2][2] > rotation[i][i]) i = 2;
    const int j = (i + 1) % 3, k = (j + 1) % 3;
    const double s =
        2 * std::sqrt(std::max(0.0, rotation[i][i] - rotation[j][j] - rotation[k][k] + 1));
    q[i + 1] = 0.25 * s;
    q[0] = (rotation[j][k] - rotation[k][j]) / s;
    q[j + 1] = (rotation[i][j] + rotation[j][i]) / s;
    q[k + 1] = (rotation[k][i] + rotation[i][k]) / s;
  }
  return result;
}

Transform AnimatedTransform::at(float time) const {
  if (!animated_ || time <= t0_) return start_;
  if (time >= t1_) return end_;
  const double s = (static_cast<double>(time) - t0_) / (static_cast<double>(t1_) - t0_);

  // Spherical interpolation of the rotations; linear when they nearly agree.
  double cosine = 0, q[4], norm = 0;
  for (int i = 0; i < 4; ++i) cosine += d0_.rotation[i] * d1_.rotation[i];
  const double angle = std::acos(std::clamp(cosine, -1.0, 1.0)), sine = std::sin(angle);
  const double w0 = sine > 1e-6 ? std::sin((1 - s) * angle) / sine : 1 - s;
  const double w1 = sine > 1e-6 ? std::sin(s * angle) / sine : s;
  for (int i = 0; i < 4; ++i) {
    q[i] = w0 * d0_.rotation[i] + w1 * d1_.rotation[i];
    norm += q[i] * q[i];
  }
  norm = std::sqrt(norm);
  const double w = q[0] / norm, x = q[1] / norm, y = q[2] / norm, z = q[3] / norm;
  const Mat3d rotation(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),  //
                       2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),  //
                       2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y));
  const Mat3d stretch = (1 - s) * Mat3d(d0_.stretch) + s * Mat3d(d1_.stretch);
  Mat4d m(rotation * stretch);
  m[3] = glm::dvec4((1 - s) * d0_.translation + s * d1_.translation, 1.0);
  return Transform(m);
}

Bounds3 AnimatedTransform::motionBounds(const Bounds3& b) const {
  if (!animated_) return start_.bounds(b);
  constexpr int kSteps = 128;
  Bounds3 swept;
  Bounds3 before;
  float largestStep = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const Bounds3 now = at(t0_ + (t1_ - t0_) * static_cast<float>(i) / kSteps).bounds(b);
    swept.extend(now);
    if (i > 0)
      largestStep = std::max({largestStep, maxComponent(abs(now.lo - before.lo)),
                              maxComponent(abs(now.hi - before.hi))});
    before = now;
  }
  // Between two steps a corner moves on an arc that leaves the box of its ends by less than a
  // fraction of the step.
  swept.lo -= Vec3(0.125f * largestStep);
  swept.hi += Vec3(0.125f * largestStep);
  return swept;
}

}  // namespace brume
