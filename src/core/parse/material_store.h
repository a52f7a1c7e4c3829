// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/material.h"
#include "core/parse/texture_store.h"

namespace brume {

/// The materials of a scene. A Material directive is made when a shape needs it, once for all
/// shapes that change nothing of it; a named material when a shape or a mix uses it.
class MaterialStore final : public Material::FactoryContext::Lookup {
 public:
  /// Directive 0 is the default, matte.
  MaterialStore(TextureStore& textures, const std::string& searchDirectory, FileCache& files,
                Log& log);

  /// A Material directive; returns its number.
  std::size_t add(PluginDirective plugin);
  /// MakeNamedMaterial: its type stands in the parameter "string type"; parameters of the current
  /// Material directive are used where its own are silent (PBRT-v2).
  void defineNamed(const std::string& name, ParamSet params, std::size_t currentDirective);
  void beginBlock() { names_.beginBlock(); }
  void endBlock() { names_.endBlock(); }

  struct ForShape {
    const Material* material = nullptr;
    std::span<const std::string> paramNames;  ///< that a Shape may override
  };
  /// The material of a directive with the shape's parameters in front, or a named material, which
  /// shapes do not override.
  ForShape forShape(std::size_t directive, ParamSet& shapeParams);
  ForShape forShape(const std::string& name);

  bool isNamed(const std::string& name) const { return names_.find(name) != nullptr; }
  const Material* findMaterial(const std::string& name) override;
  std::vector<std::string> materialNames() const override { return names_.names(); }

  /// Directives and named materials that no surface has asked for; the default does not count.
  std::size_t unusedCount() const;
  std::vector<std::unique_ptr<Material>> take() { return std::move(made_); }

 private:
  using Entry = Registry<Material>::Entry;
  /// What the names in a material's parameters mean.
  struct Bindings {
    TextureBindings textures;
    std::vector<std::pair<std::string, std::size_t>> materials;
    bool operator==(const Bindings&) const = default;
  };
  struct Definition {
    std::string type;
    ParamSet params;
    const Entry* entry = nullptr;              // looked up late for the default
    std::optional<std::size_t> fallback = {};  // directive that fills the gaps
    Bindings bindings = {};                    // named: where defined; directive: where made
    int lobes = 1;                             // materials in the tree of mixes
    const Material* made = nullptr;
    bool isUsed = false;  // by a shape, perhaps with other parameters than `made`
  };

  Bindings bind(const ParamSet& set) const;
  int countMixed(const Bindings& bindings, const SourceLocation& where) const;
  void check(Definition& definition, TextureStore::Answer answer);
  std::vector<ParamSet*> setsOf(Definition& definition);
  const Material* make(Definition& definition, std::vector<ParamSet*> sets);
  const Material* makeNamed(std::size_t index);
  const std::vector<std::string>& paramNames(const Entry& entry);

  TextureStore& textures_;
  std::string searchDirectory_;
  FileCache& files_;
  Log& log_;
  std::deque<Definition> directives_;
  std::deque<Definition> named_;
  ScopedNames<std::size_t> names_;
  const Bindings* bindings_ = nullptr;  // while a named material is made
  std::vector<std::unique_ptr<Material>> made_;
  std::unordered_map<const Entry*, std::vector<std::string>> paramNames_;
};

}  // namespace brume
