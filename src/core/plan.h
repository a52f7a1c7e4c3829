// SPDX-License-Identifier: Apache-2.0
// What a scene needs and what is left out, and why: --plan, --verbose and the statistics.
#pragma once

#include <string>
#include <vector>

#include "core/deferred.h"
#include "core/parse/scene_description.h"
#include "core/scene.h"

namespace brume {

/// Numbers of what a scene holds.
struct SceneInventory {
  std::size_t meshes = 0, triangles = 0, quadrics = 0;  ///< of all groups, each counted once
  std::size_t groups = 0, instances = 0;                ///< object definitions and their copies
  std::size_t materials = 0, specularMaterials = 0;
  std::size_t textures = 0;
  std::size_t deltaLights = 0, areaLights = 0, infiniteLights = 0, blackLights = 0;
  std::size_t volumes = 0;
  bool mediaScatter = false, mediaEmit = false;

  std::size_t lights() const { return deltaLights + areaLights + infiniteLights; }
};
SceneInventory takeInventory(const Scene& scene);

/// What a scene describes and no image of it can show.
struct IdleParts {
  std::size_t unreachingLights = 0;  ///< none of their light reaches a surface or a medium
  std::size_t clearVolumes = 0;      ///< they neither absorb, scatter nor emit
};
/// Takes it out: volumes are dropped, lights become unsampled ones. Whether a light reaches the
/// scene is asked of lights at a position only, and not when something moves.
IdleParts dropIdle(Scene::Contents& contents);

/// The decisions for one render, each made where it is used and written down here.
struct Plan {
  /// One decision. "built" or "skipped", what, and why or how much.
  struct Item {
    bool isBuilt = true;
    std::string what, why;
  };
  std::vector<Item> items;
  void build(std::string what, std::string why = {}) {
    items.push_back({true, std::move(what), std::move(why)});
  }
  void skip(std::string what, std::string why) {
    items.push_back({false, std::move(what), std::move(why)});
  }
  /// "build   WHAT: WHY", one line per decision.
  std::vector<std::string> lines() const;
};

/// What follows from the scene alone: surfaces, lights, media, textures.
Plan planScene(const SceneInventory& inventory);
/// What the file holds in vain.
void planIdle(const SceneDescription::Unused& unused, const IdleParts& idle, Plan& plan);
/// Files of textures and materials: before the render, or after it.
void planFiles(const DeferredCounts& files, bool isRendered, Plan& plan);

}  // namespace brume
