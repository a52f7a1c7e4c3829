// SPDX-License-Identifier: Apache-2.0
#include "core/plan.h"

#include <fmt/format.h>

#include "core/io/file_bytes.h"
#include "core/triangle_mesh.h"

namespace brume {
namespace {

/// "1 light", "3 lights".
std::string counted(std::size_t n, std::string_view noun) {
  return fmt::format("{} {}{}", n, noun, n == 1 ? "" : "s");
}

void countSurfaces(const Scene& scene, SceneInventory& found) {
  const auto& groups = scene.contents().groups;
  found.groups = groups.size() - 1;
  found.instances = groups.back().instances.size();
  for (const PrimitiveGroup& group : groups)
    for (const Primitive& primitive : group.primitives)
      if (const TriangleMesh* mesh = primitive.shape->mesh()) {
        ++found.meshes;
        found.triangles += mesh->triangleCount();
      } else {
        ++found.quadrics;
      }
}

void countLights(const Scene& scene, SceneInventory& found) {
  for (const auto& light : scene.lights())
    ++(light->power().isBlack() ? found.blackLights
       : light->isInfinite()    ? found.infiniteLights
       : light->isDelta()       ? found.deltaLights
                                : found.areaLights);
}

}  // namespace

SceneInventory takeInventory(const Scene& scene) {
  SceneInventory found;
  countSurfaces(scene, found);
  countLights(scene, found);
  const Scene::Contents& contents = scene.contents();
  found.materials = contents.materials.size();
  for (const auto& material : contents.materials)
    if (material->hasSpecular()) ++found.specularMaterials;
  found.textures = contents.floatTextures.size() + contents.rgbTextures.size();
  found.volumes = contents.volumes.size();
  if (const Volume* volume = scene.volume()) {
    found.mediaScatter = volume->isScattering();
    found.mediaEmit = volume->isEmissive();
  }
  return found;
}

std::vector<std::string> Plan::lines() const {
  std::vector<std::string> result;
  for (const Item& item : items)
    result.push_back(fmt::format("{} {}{}{}", item.isBuilt ? "build" : "skip ", item.what,
                                 item.why.empty() ? "" : ": ", item.why));
  return result;
}

Plan planScene(const SceneInventory& found) {
  Plan plan;
  if (found.meshes + found.quadrics == 0)
    plan.skip("surfaces", "the scene has none");
  else
    plan.build("surfaces",
               fmt::format("{} with {}, {}, {} of {}",
                           fmt::format("{} mesh{}", found.meshes, found.meshes == 1 ? "" : "es"),
                           counted(found.triangles, "triangle"), counted(found.quadrics, "quadric"),
                           counted(found.instances, "instance"), counted(found.groups, "object")));
  if (found.lights() == 0)
    plan.skip("lights", "the scene has none that lights it");
  else
    plan.build("lights", fmt::format("{} without extent, {} on surfaces, {} around the scene",
                                     found.deltaLights, found.areaLights, found.infiniteLights));
  if (found.blackLights > 0) plan.skip(counted(found.blackLights, "light"), "emitting nothing");
  if (found.volumes == 0)
    plan.skip("media", "the scene has no Volume");
  else
    plan.build("media", fmt::format("{}{}{}", counted(found.volumes, "volume"),
                                    found.mediaScatter ? ", scattering" : ", not scattering",
                                    found.mediaEmit ? ", emitting" : ""));
  if (found.textures == 0)
    plan.skip("ray footprints", "no texture looks at them");
  else
    plan.build("ray footprints", counted(found.textures, "texture"));
  return plan;
}

namespace {

/// Bounds of surfaces and media in render space; none when something moves.
std::optional<Bounds3> stillBounds(const Scene::Contents& contents) {
  Bounds3 bounds;
  const auto extend = [&](const PrimitiveGroup& group, const Transform& groupToScene) {
    for (const Primitive& primitive : group.primitives)
      bounds.extend(groupToScene.bounds(primitive.shape->bounds()));
  };
  const PrimitiveGroup& scene = contents.groups.back();
  extend(scene, Transform{});
  for (const PrimitiveGroup::Instance& instance : scene.instances) {
    if (instance.groupToParent.isAnimated()) return std::nullopt;
    extend(contents.groups[instance.group], instance.groupToParent.start());
  }
  for (const auto& volume : contents.volumes) bounds.extend(volume->bounds());
  return bounds;
}

void skipSome(Plan& plan, std::size_t n, std::string_view noun, const char* why) {
  if (n > 0) plan.skip(counted(n, noun), why);
}

}  // namespace

IdleParts dropIdle(Scene::Contents& contents) {
  IdleParts idle;
  idle.clearVolumes = std::erase_if(contents.volumes, [](const std::unique_ptr<Volume>& volume) {
    return volume->majorant().isBlack() && !volume->isEmissive();
  });
  const std::optional<Bounds3> bounds = stillBounds(contents);
  std::vector<std::unique_ptr<Light>> kept;
  for (auto& light : contents.lights) {
    const bool isUnreaching =
        bounds && !bounds->isEmpty() && light->position() && light->importance(*bounds) == 0;
    if (isUnreaching && !light->power().isBlack()) {
      ++idle.unreachingLights;
      contents.unsampledLights.push_back(std::move(light));
    } else {
      kept.push_back(std::move(light));
    }
  }
  contents.lights = std::move(kept);
  return idle;
}

void planIdle(const SceneDescription::Unused& unused, const IdleParts& idle, Plan& plan) {
  skipSome(plan, unused.objects, "object", "defined and never instanced");
  skipSome(plan, unused.materials, "material", "used by no surface");
  skipSome(plan, unused.textures, "texture", "used by no surface, so not loaded");
  skipSome(plan, idle.unreachingLights, "light", "shining past all surfaces and media");
  skipSome(plan, idle.clearVolumes, "volume", "neither absorbing, scattering nor emitting");
}

void planFiles(const DeferredCounts& files, bool isRendered, Plan& plan) {
  const auto named = [](std::size_t n) {
    return counted(n, "file") + " of textures and materials";
  };
  const std::string unread = formatBytes(files.bytesUnread);
  if (files.read > 0) plan.build(named(files.read), "read");
  if (files.unread == 0) return;
  if (isRendered)
    plan.skip(named(files.unread), fmt::format("no ray met them, {} are not taken", unread));
  else
    plan.build(named(files.unread),
               fmt::format("read when a ray first meets them, {} if it does", unread));
}

}  // namespace brume
