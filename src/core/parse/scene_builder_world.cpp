// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "core/io/source_file.h"
#include "core/parse/find_plugin.h"
#include "core/parse/scene_builder.h"
#include "core/parse/world_state.h"

namespace brume {

namespace {

/// Objects with many moving shapes, instanced many times.
constexpr std::size_t kMaxMovingInstances = 1'000'000;

/// Whether lengths in all directions are scaled alike: then interpolating a product of transforms
/// equals the product with the interpolated one.
bool isSimilarity(const Transform& t) {
  const Vec3d x(t.matrix()[0]), y(t.matrix()[1]), z(t.matrix()[2]);
  const double s = dot(x, x);
  constexpr double kTolerance = 1e-6;  // of the squared scale
  return std::abs(dot(y, y) - s) < kTolerance * s && std::abs(dot(z, z) - s) < kTolerance * s &&
         std::abs(dot(x, y)) < kTolerance * s && std::abs(dot(y, z)) < kTolerance * s &&
         std::abs(dot(z, x)) < kTolerance * s;
}

bool hasUnused(const ParamSet& set) {
  return std::any_of(set.params().begin(), set.params().end(),
                     [](const Param& p) { return !p.used; });
}

}  // namespace

Transform SceneBuilder::toRenderSpace(const Transform& ctm) const {
  return Transform::translate(-world_->contents.sceneOrigin) * ctm;
}

void SceneBuilder::lightSource(PluginDirective directive) {
  const SourceLocation where = directive.params.where();
  const auto& entry = findPlugin<Light>(directive.name, where);
  warnIfAnimated(where, "LightSource");
  Light::FactoryContext context;
  context.lightToWorld = toRenderSpace(transform_.pair().start);
  context.sceneOrigin = world_->contents.sceneOrigin;
  context.quick = settings_.quick;
  context.where = where;
  context.log = &log_;
  ParamReader reader({&directive.params}, directive.name, searchDirectory_, &world_->textures,
                     log_);
  world_->contents.lights.push_back(entry.create(reader, context, nullptr));
  reportUnusedParams(directive.params, directive.name, entry.origin, reader.declared(), log_);
}

void SceneBuilder::areaLightSource(PluginDirective directive) {
  if (directive.name.empty()) {  // the only way to turn it off within a block
    world_->graphics.areaLight = nullptr;
    return;
  }
  const auto& entry = findPlugin<AreaLight>(directive.name, directive.params.where());
  ParamReader reader({&directive.params}, directive.name, searchDirectory_, &world_->textures,
                     log_);
  entry.check(reader);
  reportUnusedParams(directive.params, directive.name, entry.origin, reader.declared(), log_);
  world_->areaLights.push_back({&entry, std::move(directive)});
  world_->graphics.areaLight = &world_->areaLights.back();
}

void SceneBuilder::volume(PluginDirective directive) {
  const SourceLocation where = directive.params.where();
  const auto& entry = findPlugin<Volume>(directive.name, where);
  warnIfAnimated(where, "Volume");
  Volume::FactoryContext context;
  context.volumeToWorld = toRenderSpace(transform_.pair().start);
  context.where = where;
  context.log = &log_;
  ParamReader reader({&directive.params}, directive.name, searchDirectory_, &world_->textures,
                     log_);
  world_->contents.volumes.push_back(entry.create(reader, context, nullptr));
  reportUnusedParams(directive.params, directive.name, entry.origin, reader.declared(), log_);
}

SceneBuilder::ShapePlace SceneBuilder::placeShape() {
  const TransformPair& ctm = transform_.pair();
  ObjectDefinition* const object = world_->openObject;
  if (object && !object->origin) object->origin = Vec3d(ctm.start.matrix()[3]);
  const Transform move =
      Transform::translate(object ? -*object->origin : -world_->contents.sceneOrigin);
  ShapePlace place;
  if (ctm.isAnimated()) {
    place.toParent = TransformPair{move * ctm.start, move * ctm.end};
  } else {
    place.objectToShape = move * ctm.start;
    place.group = object ? &object->still : &world_->scene;
  }
  return place;
}

void SceneBuilder::shape(PluginDirective directive) {
  World& world = *world_;
  const SourceLocation where = directive.params.where();
  const auto& entry = findPlugin<Shape>(directive.name, where);
  const ShapePlace place = placeShape();

  ParamReader reader({&directive.params}, directive.name, searchDirectory_, &world.textures, log_);
  Shape::FactoryContext context;
  context.objectToShape = place.objectToShape;
  context.reverseOrientation = world.graphics.reverseOrientation;
  context.where = where;
  context.log = &log_;
  world.contents.shapes.push_back(entry.create(reader, context, nullptr));
  const Shape& made = *world.contents.shapes.back();

  // A parameter of a Shape may belong to the shape or override one of the material.
  const MaterialStore::ForShape material =
      world.graphics.namedMaterial
          ? world.materials.forShape(*world.graphics.namedMaterial)
          : world.materials.forShape(world.graphics.material, directive.params);
  if (hasUnused(directive.params)) {
    std::vector<std::string> known = reader.declared();
    known.insert(known.end(), material.paramNames.begin(), material.paramNames.end());
    reportUnusedParams(directive.params, directive.name, entry.origin, known, log_);
  }

  const Primitive primitive{&made, material.material, makeAreaLight(made, place, where)};
  if (place.group) {
    place.group->primitives.push_back(primitive);
    return;
  }
  // A moving shape is alone in its group.
  PrimitiveGroup group;
  group.primitives.push_back(primitive);
  world.contents.groups.push_back(std::move(group));
  const std::size_t index = world.contents.groups.size() - 1;
  if (world.openObject)
    world.openObject->moving.push_back({index, *place.toParent});
  else
    world.scene.instances.push_back({index, animated(place.toParent->start, place.toParent->end)});
}

const AreaLight* SceneBuilder::makeAreaLight(const Shape& shape, const ShapePlace& place,
                                             const SourceLocation& where) {
  const AreaLightDefinition* definition = world_->graphics.areaLight;
  if (!definition) return nullptr;
  if (place.toParent) {
    log_.warning(where, "a moving shape cannot be an area light: it will not emit");
    return nullptr;
  }
  if (!shape.canSample()) throw SceneError(where, "this kind of shape cannot be an area light");
  AreaLight::FactoryContext context;
  context.shape = &shape;
  context.quick = settings_.quick;
  context.where = definition->plugin.params.where();
  context.log = &log_;
  ParamSet params = definition->plugin.params;
  ParamReader reader({&params}, definition->plugin.name, searchDirectory_, &world_->textures, log_);
  std::unique_ptr<AreaLight> light = definition->entry->create(reader, context, nullptr);
  const AreaLight* result = light.get();
  if (world_->openObject) {
    log_.warning(where, "an area light inside an object can be seen, but does not light the scene");
    world_->contents.unsampledLights.push_back(std::move(light));
  } else {
    world_->contents.lights.push_back(std::move(light));
  }
  return result;
}

void SceneBuilder::beginObject(const std::string& name, const SourceLocation& where) {
  if (world_->openObject)
    throw SceneError(where, "ObjectBegin inside an object: definitions do not nest");
  beginBlock(BlockKind::Object, where);
  ObjectDefinition& object = world_->objects[name];
  object = {};  // a second definition of the name replaces the first for later instances
  world_->openObject = &object;
}

void SceneBuilder::endObject(const SourceLocation& where) {
  endBlock(BlockKind::Object, where);
  ObjectDefinition& object = *std::exchange(world_->openObject, nullptr);
  if (object.still.primitives.empty()) return;
  world_->contents.groups.push_back(std::move(object.still));
  object.stillGroup = world_->contents.groups.size() - 1;
}

void SceneBuilder::instanceObject(const std::string& name, const SourceLocation& where) {
  if (world_->openObject)
    throw SceneError(where, "ObjectInstance inside an object: definitions do not nest");
  const auto it = world_->objects.find(name);
  if (it == world_->objects.end()) {
    std::vector<std::string> names;
    for (const auto& [known, object] : world_->objects) names.push_back(known);
    throw SceneError(where, fmt::format("there is no object {}{}; objects are defined between "
                                        "WorldBegin and WorldEnd, for this frame",
                                        quote(name), nearestSpelling(name, names)));
  }
  const ObjectDefinition& object = it->second;
  if (!object.origin) return;  // nothing in it
  const Transform undoMove = Transform::translate(*object.origin);
  const TransformPair& ctm = transform_.pair();
  if (object.stillGroup)
    world_->scene.instances.push_back(
        {*object.stillGroup,
         animated(toRenderSpace(ctm.start) * undoMove, toRenderSpace(ctm.end) * undoMove)});
  addMovingInstances(object, undoMove, name, where);
}

void SceneBuilder::addMovingInstances(const ObjectDefinition& object, const Transform& undoMove,
                                      const std::string& name, const SourceLocation& where) {
  if (object.moving.empty()) return;
  const TransformPair& ctm = transform_.pair();
  if (ctm.isAnimated() || !isSimilarity(ctm.start))
    log_.warning(where,
                 fmt::format("the motion inside the object {} is approximated, because this "
                             "instance of it {}",
                             quote(name), ctm.isAnimated() ? "moves too" : "scales it unevenly"));
  world_->movingInstances += object.moving.size();
  if (world_->movingInstances > kMaxMovingInstances)
    throw SceneError(where,
                     fmt::format("instances of moving shapes: more than {}", kMaxMovingInstances));
  const Transform start = toRenderSpace(ctm.start) * undoMove,
                  end = toRenderSpace(ctm.end) * undoMove;
  for (const ObjectDefinition::Moving& part : object.moving)
    world_->scene.instances.push_back(
        {part.group, animated(start * part.toDefinition.start, end * part.toDefinition.end)});
}

}  // namespace brume
