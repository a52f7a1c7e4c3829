// SPDX-License-Identifier: Apache-2.0
// From directives to a Scene: the graphics state, named things, object definitions, and the shift
// to render space.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/parse/current_transform.h"
#include "core/parse/material_store.h"
#include "core/parse/scene_description.h"
#include "core/parse/texture_store.h"

namespace brume {

/// Takes the directives of one or more frames in the order of the scene file. Throws SceneError for
/// what they get wrong.
///
/// Spaces. Static shapes, lights and volumes are made in render space: translate(-sceneOrigin) *
/// CTM. A moving shape is made in its object space, alone in a group that the scene instances with
/// the animated CTM. An object definition is a group in definition space: the world, moved so that
/// the CTM of its first shape has no translation; instances undo that move. Textures get the CTM
/// itself. Moving shapes inside an object become instances of their own, so that instances never
/// nest: their motion is exact where the instance only moves, turns and scales evenly.
class SceneBuilder {
 public:
  /// Relative file names are resolved against searchDirectory.
  SceneBuilder(const std::string& searchDirectory, const ParseSettings& settings, Log& log);
  ~SceneBuilder();

  bool isInWorld() const { return world_ != nullptr; }
  const SourceLocation& worldBeganAt() const { return worldBeganAt_; }
  CurrentTransform& transform() { return transform_; }

  // The options block.
  RenderOptions& options() { return options_; }
  void camera(PluginDirective directive);
  void transformTimes(double start, double end, const SourceLocation& where);

  void beginWorld(const SourceLocation& where);
  SceneDescription endWorld(const SourceLocation& where);

  // The world block.
  enum class BlockKind { Attribute, Transform, Object };
  void beginBlock(BlockKind kind, const SourceLocation& where);
  void endBlock(BlockKind kind, const SourceLocation& where);
  void beginObject(const std::string& name, const SourceLocation& where);
  void endObject(const SourceLocation& where);
  void instanceObject(const std::string& name, const SourceLocation& where);
  void texture(TextureStore::Directive directive);
  void material(PluginDirective directive);
  void makeNamedMaterial(const std::string& name, ParamSet params);
  void namedMaterial(const std::string& name, const SourceLocation& where);
  void reverseOrientation();
  void lightSource(PluginDirective directive);
  void areaLightSource(PluginDirective directive);
  void shape(PluginDirective directive);
  void volume(PluginDirective directive);

 private:
  struct GraphicsState;
  struct AreaLightDefinition;
  struct ObjectDefinition;
  struct Block;
  struct World;

  Transform toRenderSpace(const Transform& ctm) const;
  void warnIfAnimated(const SourceLocation& where, std::string_view what);
  /// Where a shape of the present CTM goes.
  struct ShapePlace;
  ShapePlace placeShape();
  const AreaLight* makeAreaLight(const Shape& shape, const ShapePlace& place,
                                 const SourceLocation& where);
  void addMovingInstances(const ObjectDefinition& object, const Transform& undoMove,
                          const std::string& name, const SourceLocation& where);
  AnimatedTransform animated(const Transform& start, const Transform& end) const;

  ParseSettings settings_;
  Log& log_;
  std::string searchDirectory_;
  RenderOptions options_;
  TransformPair cameraToWorld_;
  CurrentTransform transform_;
  SourceLocation worldBeganAt_;
  std::unique_ptr<World> world_;  // between WorldBegin and WorldEnd
};

}  // namespace brume
