// SPDX-License-Identifier: Apache-2.0
#include "core/parse/current_transform.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/io/source_file.h"

namespace brume {

namespace {

/// Whether matrix and inverse keep their meaning in float, in which they are applied.
bool fitsFloat(const Transform& t) {
  for (const Mat4d* m : {&t.matrix(), &t.inverseMatrix()})
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r)
        if (!(std::abs((*m)[c][r]) <= static_cast<double>(std::numeric_limits<float>::max())))
          return false;
  return true;
}

Transform fromEntries(const std::vector<double>& entries, const SourceLocation& where) {
  Mat4d m;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) m[c][r] = entries[static_cast<std::size_t>(4 * c + r)];
  if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] == 0)
    throw SceneError(where,
                     "the matrix is not affine: its last row (entries 4, 8, 12 and 16) must be "
                     "0 0 0 1");
  m /= m[3][3];
  if (!Transform::isInvertible(m)) throw SceneError(where, "the matrix cannot be inverted");
  return Transform(m);
}

}  // namespace

void CurrentTransform::identity() {
  if (state_.active.start) state_.pair.start = Transform();
  if (state_.active.end) state_.pair.end = Transform();
}

void CurrentTransform::concat(const Transform& t, const SourceLocation& where) {
  if (state_.active.start) state_.pair.start = state_.pair.start * t;
  if (state_.active.end) state_.pair.end = state_.pair.end * t;
  check(where);
}

void CurrentTransform::check(const SourceLocation& where) const {
  for (const Transform* t : {&state_.pair.start, &state_.pair.end}) {
    if (!fitsFloat(*t))
      throw SceneError(where, "the current transformation leaves the range of floats here");
    if (!Transform::isInvertible(t->matrix()))
      throw SceneError(where, "the current transformation cannot be inverted from here on");
  }
}

void CurrentTransform::translate(const double (&v)[3], const SourceLocation& where) {
  concat(Transform::translate({v[0], v[1], v[2]}), where);
}

void CurrentTransform::scale(const double (&v)[3], const SourceLocation& where) {
  if (v[0] == 0 || v[1] == 0 || v[2] == 0)
    throw SceneError(
        where, fmt::format("Scale {} {} {} flattens space: no factor may be 0", v[0], v[1], v[2]));
  concat(Transform::scale(v[0], v[1], v[2]), where);
}

void CurrentTransform::rotate(const double (&v)[4], const SourceLocation& where) {
  const Vec3d axis(v[1], v[2], v[3]);
  if (!(length(axis) > 0) || !std::isfinite(length(axis)))
    throw SceneError(where, fmt::format("Rotate about the axis {} {} {}: it needs a direction",
                                        v[1], v[2], v[3]));
  concat(Transform::rotate(v[0], axis), where);
}

void CurrentTransform::lookAt(const double (&v)[9], const SourceLocation& where) {
  const Vec3d eye(v[0], v[1], v[2]), look(v[3], v[4], v[5]), up(v[6], v[7], v[8]);
  const std::optional<Transform> t = Transform::lookAt(eye, look, up);
  if (!t)
    throw SceneError(where, eye == look
                                ? "LookAt looks at its own position: the first two points are equal"
                                : "LookAt has an up vector that is zero or parallel to the view");
  concat(*t, where);
}

void CurrentTransform::setMatrix(const std::vector<double>& entries, const SourceLocation& where) {
  identity();
  concat(fromEntries(entries, where), where);
}

void CurrentTransform::concatMatrix(const std::vector<double>& entries,
                                    const SourceLocation& where) {
  concat(fromEntries(entries, where), where);
}

void CurrentTransform::useSystem(const std::string& name, const SourceLocation& where) {
  const auto it = systems_.find(name);
  if (it == systems_.end()) {
    std::vector<std::string> names;
    for (const auto& [known, pair] : systems_) names.push_back(known);
    throw SceneError(where, fmt::format("there is no coordinate system {}{}", quote(name),
                                        nearestSpelling(name, names)));
  }
  state_.pair = it->second;
}

}  // namespace brume
