// SPDX-License-Identifier: Apache-2.0
// The options block, blocks and names; scene_builder_world.cpp makes the things of the world.
#include "core/parse/scene_builder.h"

#include <fmt/format.h>

#include "core/io/image.h"
#include "core/io/source_file.h"
#include "core/parse/world_state.h"

namespace brume {

namespace {

constexpr std::size_t kMaxOpenBlocks = 10'000;

std::string_view nameOf(SceneBuilder::BlockKind kind) {
  switch (kind) {
    case SceneBuilder::BlockKind::Attribute:
      return "Attribute";
    case SceneBuilder::BlockKind::Transform:
      return "Transform";
    case SceneBuilder::BlockKind::Object:
      return "Object";
  }
  return "";
}

/// Drops the groups that nothing instances, objects that the scene only defines; returns their
/// number.
std::size_t dropUnusedGroups(std::vector<PrimitiveGroup>& groups) {
  std::vector<PrimitiveGroup> used;
  std::vector<std::optional<std::size_t>> newIndex(groups.size());
  for (PrimitiveGroup::Instance& instance : groups.back().instances) {
    std::optional<std::size_t>& index = newIndex[instance.group];
    if (!index) {
      index = used.size();
      used.push_back(std::move(groups[instance.group]));
    }
    instance.group = *index;
  }
  used.push_back(std::move(groups.back()));
  std::swap(groups, used);
  return used.size() - groups.size();
}

}  // namespace

SceneBuilder::SceneBuilder(const std::string& searchDirectory, const ParseSettings& settings,
                           Log& log)
    : settings_(settings), log_(log), searchDirectory_(searchDirectory) {
  options_.searchDirectory = searchDirectory;
}
SceneBuilder::~SceneBuilder() = default;

void SceneBuilder::camera(PluginDirective directive) {
  options_.camera = std::move(directive);
  cameraToWorld_ = transform_.pair().inverse();
  transform_.nameSystem("camera", cameraToWorld_);
}

void SceneBuilder::transformTimes(double start, double end, const SourceLocation& where) {
  options_.transformStart = static_cast<float>(start);
  options_.transformEnd = static_cast<float>(end);
  if (!std::isfinite(options_.transformStart) || !std::isfinite(options_.transformEnd) ||
      !(options_.transformStart < options_.transformEnd))
    throw SceneError(
        where, fmt::format("TransformTimes {} {}: the end must lie after the start", start, end));
}

AnimatedTransform SceneBuilder::animated(const Transform& start, const Transform& end) const {
  return {start, options_.transformStart, end, options_.transformEnd};
}

void SceneBuilder::beginWorld(const SourceLocation& where) {
  worldBeganAt_ = where;
  world_ = std::make_unique<World>(searchDirectory_, log_);
  options_.cameraToWorld = animated(cameraToWorld_.start, cameraToWorld_.end);
  world_->contents.sceneOrigin = Vec3d(cameraToWorld_.start.matrix()[3]);
  transform_.reset();
  transform_.nameSystem("world");
  transform_.nameSystem("camera", cameraToWorld_);
}

SceneDescription SceneBuilder::endWorld(const SourceLocation& where) {
  if (!world_->blocks.empty()) {
    const Block& open = world_->blocks.back();
    throw SceneError(where, fmt::format("WorldEnd comes before {0}End ({0}Begin is at {1})",
                                        nameOf(open.kind), toString(open.where)));
  }
  SceneDescription frame{options_, std::move(world_->contents), {}};
  frame.unused.textures = world_->textures.unusedCount();
  frame.unused.materials = world_->materials.unusedCount();
  frame.world.floatTextures = world_->textures.takeFloatTextures();
  frame.world.rgbTextures = world_->textures.takeRgbTextures();
  frame.world.materials = world_->materials.take();
  frame.world.groups.push_back(std::move(world_->scene));
  frame.unused.objects = dropUnusedGroups(frame.world.groups);
  frame.world.files->drop<RgbImage>();  // pyramids have been made of them
  world_.reset();
  transform_.reset();
  transform_.forgetSystems();
  return frame;
}

void SceneBuilder::beginBlock(BlockKind kind, const SourceLocation& where) {
  if (world_->blocks.size() >= kMaxOpenBlocks)
    throw SceneError(where, fmt::format("more than {} blocks are open here", kMaxOpenBlocks));
  world_->blocks.push_back({kind, where, transform_.state(), world_->graphics});
  if (kind == BlockKind::Transform) return;
  world_->textures.beginBlock();
  world_->materials.beginBlock();
}

void SceneBuilder::endBlock(BlockKind kind, const SourceLocation& where) {
  if (world_->blocks.empty())
    throw SceneError(where, fmt::format("{0}End without {0}Begin", nameOf(kind)));
  Block& block = world_->blocks.back();
  if (block.kind != kind)
    throw SceneError(where, fmt::format("{}End inside the block that {}Begin opened at {}",
                                        nameOf(kind), nameOf(block.kind), toString(block.where)));
  transform_.restore(block.transform);
  if (kind != BlockKind::Transform) {
    world_->graphics = std::move(block.graphics);
    world_->textures.endBlock();
    world_->materials.endBlock();
  }
  world_->blocks.pop_back();
}

void SceneBuilder::texture(TextureStore::Directive directive) {
  warnIfAnimated(directive.plugin.params.where(), "Texture");
  world_->textures.define(std::move(directive), transform_.pair().start);
}

void SceneBuilder::material(PluginDirective directive) {
  world_->graphics.material = world_->materials.add(std::move(directive));
  world_->graphics.namedMaterial.reset();
}

void SceneBuilder::makeNamedMaterial(const std::string& name, ParamSet params) {
  world_->materials.defineNamed(name, std::move(params), world_->graphics.material);
}

void SceneBuilder::namedMaterial(const std::string& name, const SourceLocation& where) {
  if (!world_->materials.isNamed(name))
    throw SceneError(where, fmt::format("there is no named material {}{}", quote(name),
                                        nearestSpelling(name, world_->materials.materialNames())));
  world_->graphics.namedMaterial = name;
}

void SceneBuilder::reverseOrientation() {
  world_->graphics.reverseOrientation = !world_->graphics.reverseOrientation;
}

void SceneBuilder::warnIfAnimated(const SourceLocation& where, std::string_view what) {
  if (transform_.pair().isAnimated())
    log_.warning(where, fmt::format("a {} does not move: the transformation at the start time is "
                                    "used",
                                    what));
}

}  // namespace brume
