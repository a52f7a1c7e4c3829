// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/log.h"
#include "core/parse/scene_description.h"
#include "core/parse/scoped_names.h"
#include "core/registry.h"
#include "core/texture.h"

namespace brume {

/// What the texture names in a parameter list stood for at one moment: indices into the store.
struct TextureBindings {
  struct Binding {
    std::string name;
    std::optional<std::size_t> asFloat, asRgb;
    bool operator==(const Binding&) const = default;
  };
  std::vector<Binding> list;
  bool operator==(const TextureBindings&) const = default;
};

/// The named textures of a scene, in two name spaces. A texture's parameters are checked where it
/// is defined, and names in them mean what they mean there; it is made when something that is used
/// asks for it.
class TextureStore final : public TextureLookup {
 public:
  TextureStore(const std::string& searchDirectory, FileCache& files, Log& log)
      : searchDirectory_(searchDirectory), files_(files), log_(log) {}

  struct Directive {
    std::string name;        ///< of the texture
    std::string type;        ///< "float", "color" or "spectrum"
    SourceLocation typeAt;   ///< where the type stands
    PluginDirective plugin;  ///< the class and its parameters
  };
  void define(Directive directive, const Transform& textureToScene);
  void beginBlock();
  void endBlock();
  TextureBindings bind(const ParamSet& set) const;

  /// How names are answered while it lives.
  enum class Answer {
    Texture,    ///< the texture, made when it was not yet
    Existence,  ///< a stand-in, null for unknown names; for checks
    Anything    ///< a stand-in even for unknown names, which may still be defined
  };
  class [[nodiscard]] LookupScope {
   public:
    /// bindings: what names mean; null: what they mean now.
    LookupScope(TextureStore& store, const TextureBindings* bindings, Answer answer)
        : store_(store), bindings_(store.bindings_), answer_(store.answer_) {
      store.bindings_ = bindings;
      store.answer_ = answer;
    }
    ~LookupScope() {
      store_.bindings_ = bindings_;
      store_.answer_ = answer_;
    }
    LookupScope(const LookupScope&) = delete;
    LookupScope& operator=(const LookupScope&) = delete;

   private:
    TextureStore& store_;
    const TextureBindings* bindings_;
    Answer answer_;
  };

  const Texture<float>* findFloatTexture(const std::string& name) override;
  const Texture<Rgb>* findRgbTexture(const std::string& name) override;
  std::vector<std::string> textureNames(bool isFloat) const override;

  /// Textures that are defined and that nothing has asked for.
  std::size_t unusedCount() const {
    return floats_.definitions.size() - floats_.made.size() + rgbs_.definitions.size() -
           rgbs_.made.size();
  }
  std::vector<std::unique_ptr<Texture<float>>> takeFloatTextures();
  std::vector<std::unique_ptr<Texture<Rgb>>> takeRgbTextures();

 private:
  template <class T>
  struct Definition {
    const typename Registry<Texture<T>>::Entry* entry;
    PluginDirective plugin;
    Transform textureToScene;
    TextureBindings bindings;
    int depth = 1;        ///< of the tree of textures that it looks up
    int evaluations = 1;  ///< of textures for one look-up
    const Texture<T>* made = nullptr;
  };
  template <class T>
  struct NameSpace {
    std::deque<Definition<T>> definitions;
    ScopedNames<std::size_t> names;
    std::vector<std::unique_ptr<Texture<T>>> made;
  };
  template <class T>
  void defineIn(NameSpace<T>& space, Directive directive, const Transform& textureToScene);
  template <class T>
  void limitTree(Definition<T>& definition) const;
  template <class T>
  const Texture<T>* find(NameSpace<T>& space, const std::string& name);
  template <class T>
  const Texture<T>* make(NameSpace<T>& space, std::size_t index);

  std::string searchDirectory_;
  FileCache& files_;
  Log& log_;
  NameSpace<float> floats_;
  NameSpace<Rgb> rgbs_;
  const TextureBindings* bindings_ = nullptr;
  Answer answer_ = Answer::Texture;
};

}  // namespace brume
