// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

#include "core/error.h"
#include "core/transform.h"

namespace brume {

/// The two current transformation matrices, object to world, at the two TransformTimes; in double.
struct TransformPair {
  Transform start, end;
  bool isAnimated() const { return !(start == end); }
  TransformPair inverse() const { return {start.inverse(), end.inverse()}; }
};

/// The current transformation and the named coordinate systems. Every change is checked: what is
/// not finite or cannot be inverted is a SceneError at the directive.
class CurrentTransform {
 public:
  /// Which of the pair the transform directives edit.
  struct Active {
    bool start = true, end = true;
  };
  struct State {
    TransformPair pair;
    Active active;
  };

  const TransformPair& pair() const { return state_.pair; }
  const State& state() const { return state_; }
  void restore(const State& state) { state_ = state; }
  void reset() { state_ = {}; }
  void setActive(Active active) { state_.active = active; }

  void identity();
  void translate(const double (&v)[3], const SourceLocation& where);
  void scale(const double (&v)[3], const SourceLocation& where);
  void rotate(const double (&v)[4], const SourceLocation& where);
  void lookAt(const double (&v)[9], const SourceLocation& where);
  /// Column-major entries; replaces, or multiplies from the right.
  void setMatrix(const std::vector<double>& entries, const SourceLocation& where);
  void concatMatrix(const std::vector<double>& entries, const SourceLocation& where);

  void nameSystem(const std::string& name) { systems_[name] = state_.pair; }
  void nameSystem(const std::string& name, const TransformPair& pair) { systems_[name] = pair; }
  void useSystem(const std::string& name, const SourceLocation& where);
  void forgetSystems() { systems_.clear(); }

 private:
  void concat(const Transform& t, const SourceLocation& where);
  void check(const SourceLocation& where) const;

  State state_;
  std::unordered_map<std::string, TransformPair> systems_;
};

}  // namespace brume
