// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/params.h"
#include "core/parse/token_stream.h"

namespace brume {

/// What the type word of a parameter says about its values.
enum class ValueKind {
  Float,
  Integer,
  Bool,
  Point,
  Vector,
  Normal,
  String,
  Texture,
  Rgb,
  Xyz,
  Blackbody,
  Spectrum
};

/// The string in front of the values, taken apart.
struct ParamDeclaration {
  ValueKind kind;
  ParamType type;       ///< Color for the last four kinds
  std::string written;  ///< "type name" in quotes, shortened, for messages
  std::string name;
  SourceLocation where;
};

/// Throws SceneError for an unknown type or a missing name.
ParamDeclaration parseDeclaration(const Token& token);

}  // namespace brume
