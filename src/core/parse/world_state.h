// SPDX-License-Identifier: Apache-2.0
// What SceneBuilder holds between WorldBegin and WorldEnd.
#pragma once

#include "core/parse/scene_builder.h"

namespace brume {

/// What AttributeBegin saves and AttributeEnd restores, beside names and transformation.
struct SceneBuilder::GraphicsState {
  std::size_t material = 0;                  // directive in the MaterialStore
  std::optional<std::string> namedMaterial;  // instead of it
  const AreaLightDefinition* areaLight = nullptr;
  bool reverseOrientation = false;
};

struct SceneBuilder::AreaLightDefinition {
  const Registry<AreaLight>::Entry* entry;
  PluginDirective plugin;
};

/// The shapes between ObjectBegin and ObjectEnd.
struct SceneBuilder::ObjectDefinition {
  struct Moving {
    std::size_t group;
    TransformPair toDefinition;
  };
  PrimitiveGroup still;
  std::optional<std::size_t> stillGroup;  // none while it is open, or when nothing in it is still
  std::vector<Moving> moving;
  std::optional<Vec3d> origin;  // world position of the origin of definition space
};

/// An open block and what its end restores.
struct SceneBuilder::Block {
  BlockKind kind;
  SourceLocation where;
  CurrentTransform::State transform;
  GraphicsState graphics;
};

/// Where a shape is made, and where its primitive goes.
struct SceneBuilder::ShapePlace {
  Transform objectToShape;
  PrimitiveGroup* group = nullptr;        // for a still shape
  std::optional<TransformPair> toParent;  // for a moving one: its group to the scene or definition
};

struct SceneBuilder::World {
  World(const std::string& searchDirectory, Log& log)
      : textures(searchDirectory, *contents.files, log),
        materials(textures, searchDirectory, *contents.files, log) {
    contents.groups.clear();  // the scene becomes the last one
  }

  static Scene::Contents withFileCache() {
    Scene::Contents contents;
    contents.files = std::make_unique<FileCache>();
    return contents;
  }

  Scene::Contents contents = withFileCache();
  TextureStore textures;
  MaterialStore materials;
  GraphicsState graphics;
  std::vector<Block> blocks;
  std::deque<AreaLightDefinition> areaLights;
  std::unordered_map<std::string, ObjectDefinition> objects;
  ObjectDefinition* openObject = nullptr;
  std::size_t movingInstances = 0;  // that instances of objects have added
  PrimitiveGroup scene;
};

}  // namespace brume
