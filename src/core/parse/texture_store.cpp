// SPDX-License-Identifier: Apache-2.0
#include "core/parse/texture_store.h"

#include <fmt/format.h>

#include "core/io/source_file.h"
#include "core/parse/find_plugin.h"

namespace brume {

namespace {

// Textures of textures form a tree that is walked for every look-up.
constexpr int kMaxDepth = 100;
constexpr int kMaxEvaluations = 4096;

/// What check-only look-ups return; never evaluated.
template <class T>
class StandIn final : public Texture<T> {
 public:
  T evaluate(const TextureContext&) const override { return T{}; }
};

}  // namespace

void TextureStore::define(Directive directive, const Transform& textureToScene) {
  if (directive.type == "float") {
    defineIn(floats_, std::move(directive), textureToScene);
  } else if (directive.type == "color" || directive.type == "spectrum") {
    defineIn(rgbs_, std::move(directive), textureToScene);
  } else {
    const std::vector<std::string> types{"float", "color", "spectrum"};
    throw SceneError(directive.typeAt,
                     fmt::format("{} is no texture type: {}{}", quote(directive.type),
                                 listChoices(types), nearestSpelling(directive.type, types)));
  }
}

template <class T>
void TextureStore::defineIn(NameSpace<T>& space, Directive directive,
                            const Transform& textureToScene) {
  PluginDirective& plugin = directive.plugin;
  const auto& entry = findPlugin<Texture<T>>(plugin.name, plugin.params.where());

  // Names mean what they mean here, so a new texture may refer to an old one of its own name.
  TextureBindings bindings = bind(plugin.params);
  {
    const LookupScope scope(*this, nullptr, Answer::Existence);
    ParamReader reader({&plugin.params}, plugin.name, searchDirectory_, this, log_);
    entry.check(reader);
    reportUnusedParams(plugin.params, plugin.name, entry.origin, reader.declared(), log_);
  }
  Definition<T> definition{&entry, std::move(plugin), textureToScene, std::move(bindings)};
  limitTree(definition);
  space.definitions.push_back(std::move(definition));
  space.names.set(directive.name, space.definitions.size() - 1);
}

template <class T>
void TextureStore::limitTree(Definition<T>& definition) const {
  const auto add = [&](const auto& used) {
    definition.depth = std::max(definition.depth, used.depth + 1);
    definition.evaluations += used.evaluations;
  };
  for (const TextureBindings::Binding& b : definition.bindings.list) {
    if (b.asFloat) add(floats_.definitions[*b.asFloat]);
    if (b.asRgb) add(rgbs_.definitions[*b.asRgb]);
    if (definition.depth > kMaxDepth || definition.evaluations > kMaxEvaluations)
      throw SceneError(definition.plugin.params.where(),
                       fmt::format("this texture looks up more than {} others, or others nested "
                                   "more than {} deep",
                                   kMaxEvaluations, kMaxDepth));
  }
}

void TextureStore::beginBlock() {
  floats_.names.beginBlock();
  rgbs_.names.beginBlock();
}

void TextureStore::endBlock() {
  floats_.names.endBlock();
  rgbs_.names.endBlock();
}

TextureBindings TextureStore::bind(const ParamSet& set) const {
  TextureBindings bindings;
  const auto indexOf = [](const auto& space, const std::string& name) {
    const std::size_t* index = space.names.find(name);
    return index ? std::optional<std::size_t>(*index) : std::nullopt;
  };
  for (const Param& p : set.params()) {
    if (p.type != ParamType::Texture) continue;
    const std::string& name = std::get<std::vector<std::string>>(p.values).front();
    bindings.list.push_back({name, indexOf(floats_, name), indexOf(rgbs_, name)});
  }
  return bindings;
}

template <class T>
const Texture<T>* TextureStore::find(NameSpace<T>& space, const std::string& name) {
  static const StandIn<T> standIn;
  std::optional<std::size_t> index;
  if (bindings_) {
    for (const TextureBindings::Binding& b : bindings_->list)
      if (b.name == name) index = std::is_same_v<T, float> ? b.asFloat : b.asRgb;
  } else if (const std::size_t* now = space.names.find(name)) {
    index = *now;
  }
  if (answer_ == Answer::Anything) return &standIn;
  if (!index) return nullptr;
  return answer_ == Answer::Existence ? &standIn : make(space, *index);
}

template <class T>
const Texture<T>* TextureStore::make(NameSpace<T>& space, std::size_t index) {
  Definition<T>& definition = space.definitions[index];
  if (!definition.made) {
    const LookupScope scope(*this, &definition.bindings, Answer::Texture);
    ParamSet& params = definition.plugin.params;
    ParamReader reader({&params}, definition.plugin.name, searchDirectory_, this, log_);
    std::unique_ptr<Texture<T>> texture = definition.entry->create(
        reader, {definition.textureToScene, params.where(), &log_, &files_}, nullptr);
    definition.made = texture.get();
    space.made.push_back(std::move(texture));
  }
  return definition.made;
}

const Texture<float>* TextureStore::findFloatTexture(const std::string& name) {
  return find(floats_, name);
}
const Texture<Rgb>* TextureStore::findRgbTexture(const std::string& name) {
  return find(rgbs_, name);
}

std::vector<std::string> TextureStore::textureNames(bool isFloat) const {
  return isFloat ? floats_.names.names() : rgbs_.names.names();
}

std::vector<std::unique_ptr<Texture<float>>> TextureStore::takeFloatTextures() {
  return std::move(floats_.made);
}
std::vector<std::unique_ptr<Texture<Rgb>>> TextureStore::takeRgbTextures() {
  return std::move(rgbs_.made);
}

}  // namespace brume
