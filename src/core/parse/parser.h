// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "core/parse/param_list.h"
#include "core/parse/scene_builder.h"

namespace brume {

/// Turns the tokens of one file into calls of the SceneBuilder, one directive after another.
class Parser {
 public:
  using OnFrame = std::function<void(SceneDescription)>;
  Parser(TokenStream& tokens, SceneBuilder& builder, Log& log, const OnFrame& onFrame);

  /// Reads to the end. Returns its place.
  SourceLocation run();

 private:
  enum class Allowed { Anywhere, InOptions, InWorld };
  struct Directive;
  static const Directive kDirectives[];
  static const Directive& findDirective(const Token& word);
  void checkBlock(const Directive& directive, const SourceLocation& where) const;

  // Arguments of the directive that is being read.
  template <std::size_t N>
  void readNumbers(double (&values)[N]);
  Token readString(std::string_view what);
  PluginDirective readPlugin();
  void readActiveTransform();
  void readTexture();

  TokenStream& tokens_;
  SceneBuilder& builder_;
  const OnFrame& onFrame_;
  ParamListReader params_;
  std::string_view directive_;  // its name
};

}  // namespace brume
