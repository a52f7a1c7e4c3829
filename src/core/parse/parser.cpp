// SPDX-License-Identifier: Apache-2.0
#include "core/parse/parser.h"

#include <fmt/format.h>

#include <algorithm>

namespace brume {

struct Parser::Directive {
  std::string_view name;
  Allowed allowed;
  void (*read)(Parser&, const SourceLocation& where);  // arguments, and what follows from them
};

// The scene language, in the order of the manual: options, transformations, world.
const Parser::Directive Parser::kDirectives[] = {
    {"Camera", Allowed::InOptions, [](Parser& p, const SourceLocation&) {
       p.builder_.camera(p.readPlugin());
     }},
    {"Film", Allowed::InOptions, [](Parser& p, const SourceLocation&) {
       p.builder_.options().film = p.readPlugin();
     }},
    {"PixelFilter", Allowed::InOptions, [](Parser& p, const SourceLocation&) {
       p.builder_.options().filter = p.readPlugin();
     }},
    {"Sampler", Allowed::InOptions, [](Parser& p, const SourceLocation&) {
       p.builder_.options().sampler = p.readPlugin();
     }},
    {"Accelerator", Allowed::InOptions, [](Parser& p, const SourceLocation&) {
       p.builder_.options().accelerator = p.readPlugin();
     }},
    {"Renderer", Allowed::InOptions, [](Parser& p, const SourceLocation&) {
       p.builder_.options().renderer = p.readPlugin();
     }},
    {"SurfaceIntegrator", Allowed::InOptions, [](Parser& p, const SourceLocation&) {
       p.builder_.options().surfaceIntegrator = p.readPlugin();
     }},
    {"VolumeIntegrator", Allowed::InOptions, [](Parser& p, const SourceLocation&) {
       p.builder_.options().volumeIntegrator = p.readPlugin();
     }},
    {"GlobalIntegrator", Allowed::InOptions, [](Parser& p, const SourceLocation&) {
       p.builder_.options().globalIntegrator = p.readPlugin();
     }},
    {"TransformTimes", Allowed::InOptions, [](Parser& p, const SourceLocation& where) {
       double v[2];
       p.readNumbers(v);
       p.builder_.transformTimes(v[0], v[1], where);
     }},

    {"Identity", Allowed::Anywhere, [](Parser& p, const SourceLocation&) {
       p.builder_.transform().identity();
     }},
    {"Translate", Allowed::Anywhere, [](Parser& p, const SourceLocation& where) {
       double v[3];
       p.readNumbers(v);
       p.builder_.transform().translate(v, where);
     }},
    {"Scale", Allowed::Anywhere, [](Parser& p, const SourceLocation& where) {
       double v[3];
       p.readNumbers(v);
       p.builder_.transform().scale(v, where);
     }},
    {"Rotate", Allowed::Anywhere, [](Parser& p, const SourceLocation& where) {
       double v[4];
       p.readNumbers(v);
       p.builder_.transform().rotate(v, where);
     }},
    {"LookAt", Allowed::Anywhere, [](Parser& p, const SourceLocation& where) {
       double v[9];
       p.readNumbers(v);
       p.builder_.transform().lookAt(v, where);
     }},
    {"Transform", Allowed::Anywhere, [](Parser& p, const SourceLocation& where) {
       p.builder_.transform().setMatrix(p.params_.readMatrix(p.directive_), where);
     }},
    {"ConcatTransform", Allowed::Anywhere, [](Parser& p, const SourceLocation& where) {
       p.builder_.transform().concatMatrix(p.params_.readMatrix(p.directive_), where);
     }},
    {"CoordinateSystem", Allowed::Anywhere, [](Parser& p, const SourceLocation&) {
       p.builder_.transform().nameSystem(p.readString("a name").text);
     }},
    {"CoordSysTransform", Allowed::Anywhere, [](Parser& p, const SourceLocation&) {
       const Token name = p.readString("the name of a coordinate system");
       p.builder_.transform().useSystem(name.text, name.where);
     }},
    {"ActiveTransform", Allowed::Anywhere, [](Parser& p, const SourceLocation&) {
       p.readActiveTransform();
     }},

    {"WorldBegin", Allowed::InOptions, [](Parser& p, const SourceLocation& where) {
       p.builder_.beginWorld(where);
     }},
    {"WorldEnd", Allowed::InWorld, [](Parser& p, const SourceLocation& where) {
       p.onFrame_(p.builder_.endWorld(where));
     }},
    {"AttributeBegin", Allowed::InWorld, [](Parser& p, const SourceLocation& where) {
       p.builder_.beginBlock(SceneBuilder::BlockKind::Attribute, where);
     }},
    {"AttributeEnd", Allowed::InWorld, [](Parser& p, const SourceLocation& where) {
       p.builder_.endBlock(SceneBuilder::BlockKind::Attribute, where);
     }},
    {"TransformBegin", Allowed::InWorld, [](Parser& p, const SourceLocation& where) {
       p.builder_.beginBlock(SceneBuilder::BlockKind::Transform, where);
     }},
    {"TransformEnd", Allowed::InWorld, [](Parser& p, const SourceLocation& where) {
       p.builder_.endBlock(SceneBuilder::BlockKind::Transform, where);
     }},
    {"ObjectBegin", Allowed::InWorld, [](Parser& p, const SourceLocation& where) {
       p.builder_.beginObject(p.readString("the name of an object").text, where);
     }},
    {"ObjectEnd", Allowed::InWorld, [](Parser& p, const SourceLocation& where) {
       p.builder_.endObject(where);
     }},
    {"ObjectInstance", Allowed::InWorld, [](Parser& p, const SourceLocation&) {
       const Token name = p.readString("the name of an object");
       p.builder_.instanceObject(name.text, name.where);
     }},
    {"Texture", Allowed::InWorld, [](Parser& p, const SourceLocation&) { p.readTexture(); }},
    {"Material", Allowed::InWorld, [](Parser& p, const SourceLocation&) {
       p.builder_.material(p.readPlugin());
     }},
    {"MakeNamedMaterial", Allowed::InWorld, [](Parser& p, const SourceLocation&) {
       PluginDirective named = p.readPlugin();
       p.builder_.makeNamedMaterial(named.name, std::move(named.params));
     }},
    {"NamedMaterial", Allowed::InWorld, [](Parser& p, const SourceLocation&) {
       const Token name = p.readString("the name of a material");
       p.builder_.namedMaterial(name.text, name.where);
     }},
    {"ReverseOrientation", Allowed::InWorld, [](Parser& p, const SourceLocation&) {
       p.builder_.reverseOrientation();
     }},
    {"LightSource", Allowed::InWorld, [](Parser& p, const SourceLocation&) {
       p.builder_.lightSource(p.readPlugin());
     }},
    {"AreaLightSource", Allowed::InWorld, [](Parser& p, const SourceLocation&) {
       p.builder_.areaLightSource(p.readPlugin());
     }},
    {"Shape", Allowed::InWorld, [](Parser& p, const SourceLocation&) {
       p.builder_.shape(p.readPlugin());
     }},
    {"Volume", Allowed::InWorld, [](Parser& p, const SourceLocation&) {
       p.builder_.volume(p.readPlugin());
     }},
    {"Include", Allowed::Anywhere, [](Parser& p, const SourceLocation&) {
       const Token name = p.readString("a file name");
       p.tokens_.include(name.text, name.where);
     }},
};

Parser::Parser(TokenStream& tokens, SceneBuilder& builder, Log& log, const OnFrame& onFrame)
    : tokens_(tokens), builder_(builder), onFrame_(onFrame), params_(tokens, log) {}

SourceLocation Parser::run() {
  for (;;) {
    const Token token = tokens_.next();
    if (token.kind == Token::Kind::End) return token.where;
    if (token.kind != Token::Kind::Word)
      throw SceneError(
          token.where,
          fmt::format("a directive is expected here, not {}{}", describe(token),
                      directive_.empty() ? "" : fmt::format(" (after {})", directive_)));
    const Directive& directive = findDirective(token);
    checkBlock(directive, token.where);
    directive_ = directive.name;
    directive.read(*this, token.where);
  }
}

const Parser::Directive& Parser::findDirective(const Token& word) {
  const auto* found = std::find_if(std::begin(kDirectives), std::end(kDirectives),
                                   [&](const Directive& d) { return d.name == word.text; });
  if (found == std::end(kDirectives)) {
    std::vector<std::string> names;
    for (const Directive& d : kDirectives) names.emplace_back(d.name);
    throw SceneError(word.where, fmt::format("there is no directive {}{}", quote(word.text),
                                             nearestSpelling(word.text, names)));
  }
  return *found;
}

void Parser::checkBlock(const Directive& directive, const SourceLocation& where) const {
  if (directive.name == "WorldBegin" && builder_.isInWorld())
    throw SceneError(where, fmt::format("WorldBegin inside the world that began at {}",
                                        toString(builder_.worldBeganAt())));
  if (directive.allowed == Allowed::InOptions && builder_.isInWorld())
    throw SceneError(where, fmt::format("{} belongs before WorldBegin (which is at {})",
                                        directive.name, toString(builder_.worldBeganAt())));
  if (directive.allowed == Allowed::InWorld && !builder_.isInWorld())
    throw SceneError(where,
                     fmt::format("{} belongs between WorldBegin and WorldEnd", directive.name));
}

template <std::size_t N>
void Parser::readNumbers(double (&values)[N]) {
  for (std::size_t i = 0; i < N; ++i) {
    const Token token = tokens_.next();
    if (token.kind != Token::Kind::Number)
      throw SceneError(token.where,
                       fmt::format("{} takes {} numbers, but after {} of them comes {}", directive_,
                                   N, i, describe(token)));
    values[i] = token.number;
  }
}

Token Parser::readString(std::string_view what) {
  Token token = tokens_.next();
  if (token.kind != Token::Kind::String)
    throw SceneError(token.where, fmt::format("{} takes {} in quotes, not {}", directive_, what,
                                              describe(token)));
  return token;
}

PluginDirective Parser::readPlugin() {
  Token name = readString("a name");
  return {std::move(name.text), params_.read(name.where)};
}

void Parser::readActiveTransform() {
  const Token token = tokens_.next();
  if (token.kind == Token::Kind::Word && token.text == "All")
    builder_.transform().setActive({true, true});
  else if (token.kind == Token::Kind::Word && token.text == "StartTime")
    builder_.transform().setActive({true, false});
  else if (token.kind == Token::Kind::Word && token.text == "EndTime")
    builder_.transform().setActive({false, true});
  else
    throw SceneError(
        token.where,
        fmt::format("ActiveTransform takes All, StartTime or EndTime, not {}{}", describe(token),
                    nearestSpelling(token.text, {"All", "StartTime", "EndTime"})));
}

void Parser::readTexture() {
  TextureStore::Directive texture;
  texture.name = readString("the name of the texture").text;
  Token type = readString("a type");
  texture.type = std::move(type.text);
  texture.typeAt = type.where;
  texture.plugin = readPlugin();
  builder_.texture(std::move(texture));
}

}  // namespace brume
