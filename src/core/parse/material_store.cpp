// SPDX-License-Identifier: Apache-2.0
#include "core/parse/material_store.h"

#include <fmt/format.h>

#include "core/io/source_file.h"
#include "core/parse/find_plugin.h"

namespace brume {

namespace {

constexpr int kMaxMixed = 64;  // materials that one mix may reach through others

}  // namespace

MaterialStore::MaterialStore(TextureStore& textures, const std::string& searchDirectory,
                             FileCache& files, Log& log)
    : textures_(textures), searchDirectory_(searchDirectory), files_(files), log_(log) {
  Definition standard;
  standard.type = "matte";
  directives_.push_back(std::move(standard));
}

std::size_t MaterialStore::add(PluginDirective plugin) {
  Definition definition{std::move(plugin.name), std::move(plugin.params)};
  definition.entry = &findPlugin<Material>(definition.type, definition.params.where());
  // A texture that it names may still be defined before the first shape.
  check(definition, TextureStore::Answer::Anything);
  directives_.push_back(std::move(definition));
  return directives_.size() - 1;
}

void MaterialStore::defineNamed(const std::string& name, ParamSet params,
                                std::size_t currentDirective) {
  Definition definition;
  definition.fallback = currentDirective;
  Param* type = params.find(ParamType::String, "type");
  if (!type) type = directives_[currentDirective].params.find(ParamType::String, "type");
  if (!type)
    throw SceneError(params.where(),
                     fmt::format("the named material {} has no \"string type\"", quote(name)));
  if (type->count() != 1)
    throw SceneError(type->where, "\"string type\" takes one name of a material");
  type->used = true;
  definition.type = std::get<std::vector<std::string>>(type->values).front();
  definition.entry = &findPlugin<Material>(definition.type, type->where);
  definition.params = std::move(params);

  check(definition, TextureStore::Answer::Existence);
  definition.bindings = bind(definition.params);
  const Bindings leaked = bind(directives_[currentDirective].params);
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(definition.bindings.textures.list, leaked.textures.list);
  append(definition.bindings.materials, leaked.materials);
  definition.lobes = countMixed(definition.bindings, definition.params.where());
  named_.push_back(std::move(definition));
  names_.set(name, named_.size() - 1);
}

/// Reads the parameters without making anything.
void MaterialStore::check(Definition& definition, TextureStore::Answer answer) {
  const TextureStore::LookupScope scope(textures_, nullptr, answer);
  ParamReader reader(setsOf(definition), definition.type, searchDirectory_, &textures_, log_);
  definition.entry->check(reader);
  reportUnusedParams(definition.params, definition.type, definition.entry->origin,
                     reader.declared(), log_);
}

std::vector<ParamSet*> MaterialStore::setsOf(Definition& definition) {
  std::vector<ParamSet*> sets{&definition.params};
  if (definition.fallback) sets.push_back(&directives_[*definition.fallback].params);
  return sets;
}

MaterialStore::Bindings MaterialStore::bind(const ParamSet& set) const {
  Bindings bindings{textures_.bind(set), {}};
  for (const Param& p : set.params()) {
    if (p.type != ParamType::String) continue;
    for (const std::string& word : std::get<std::vector<std::string>>(p.values))
      if (const std::size_t* index = names_.find(word))
        bindings.materials.push_back({word, *index});
  }
  return bindings;
}

/// Materials that are evaluated for one hit: a mix of mixes doubles with every level.
int MaterialStore::countMixed(const Bindings& bindings, const SourceLocation& where) const {
  int count = 1;
  for (const auto& [name, index] : bindings.materials) {
    count += named_[index].lobes;
    if (count > kMaxMixed)
      throw SceneError(where, fmt::format("this mixes more than {} materials", kMaxMixed));
  }
  return count;
}

const std::vector<std::string>& MaterialStore::paramNames(const Entry& entry) {
  const auto [it, isNew] = paramNames_.try_emplace(&entry);
  if (isNew)
    for (const ParamRecord& record : entry.describe()) it->second.push_back(record.name);
  return it->second;
}

MaterialStore::ForShape MaterialStore::forShape(std::size_t directive, ParamSet& shapeParams) {
  Definition& definition = directives_[directive];
  if (!definition.entry) definition.entry = &findPlugin<Material>(definition.type, {});
  ForShape result{nullptr, paramNames(*definition.entry)};
  const bool overrides =
      std::any_of(result.paramNames.begin(), result.paramNames.end(),
                  [&](const std::string& name) { return shapeParams.findName(name) != nullptr; });
  if (overrides) {
    result.material = make(definition, {&shapeParams, &definition.params});
    return result;
  }
  // Names in a Material mean what they mean at the Shape (PBRT-v2), so the material is made anew
  // when one has been redefined.
  Bindings now = bind(definition.params);
  if (!definition.made || now != definition.bindings) {
    countMixed(now, definition.params.where());
    definition.bindings = std::move(now);
    definition.made = make(definition, {&definition.params});
  }
  result.material = definition.made;
  return result;
}

MaterialStore::ForShape MaterialStore::forShape(const std::string& name) {
  const Material* material = findMaterial(name);
  BRUME_CHECK(material);  // NamedMaterial has checked the name
  return {material, {}};
}

std::size_t MaterialStore::unusedCount() const {
  const auto isUnused = [](const Definition& d) { return !d.isUsed; };
  return static_cast<std::size_t>(
      std::count_if(directives_.begin() + 1, directives_.end(), isUnused) +
      std::count_if(named_.begin(), named_.end(), isUnused));
}

const Material* MaterialStore::make(Definition& definition, std::vector<ParamSet*> sets) {
  const SourceLocation where = definition.params.where();
  definition.isUsed = true;
  ParamReader reader(std::move(sets), definition.type, searchDirectory_, &textures_, log_);
  made_.push_back(definition.entry->create(reader, {this, where, &log_, &files_}, nullptr));
  return made_.back().get();
}

const Material* MaterialStore::makeNamed(std::size_t index) {
  Definition& definition = named_[index];
  if (!definition.made) {
    const Bindings* outer = std::exchange(bindings_, &definition.bindings);
    const TextureStore::LookupScope scope(textures_, &definition.bindings.textures,
                                          TextureStore::Answer::Texture);
    definition.made = make(definition, setsOf(definition));
    bindings_ = outer;
  }
  return definition.made;
}

const Material* MaterialStore::findMaterial(const std::string& name) {
  if (bindings_) {
    for (const auto& [bound, index] : bindings_->materials)
      if (bound == name) return makeNamed(index);
    return nullptr;
  }
  const std::size_t* index = names_.find(name);
  return index ? makeNamed(*index) : nullptr;
}

}  // namespace brume
