// SPDX-License-Identifier: Apache-2.0
// The image loop of integrators that answer per camera ray.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

#include "core/camera.h"
#include "core/film.h"
#include "core/integrator.h"
#include "renderers/image_renderer.h"

namespace brume {

/// What a tile renderer works with; everything outlives it.
struct TileRenderParts {
  const Camera& camera;
  const Sampler& sampler;
  Film& film;
  const RayRadiance& radiance;
  std::uint64_t seed = 0;
  bool footprints = true;        ///< whether any texture will look at the rays' differentials
  const Scene* scene = nullptr;  ///< for the layers, in a film that has them
};

/// Renders ranges of samples into a film. Tiles of fixed size are begun in order by whichever
/// thread is free, and merged in order: the same bits for any number of threads. Few tiles wait at
/// a time, so memory is bounded.
class TileRenderer final : public ImageRenderer {
 public:
  static constexpr int kTileSize = 16;  ///< pixels of the sampled area

  explicit TileRenderer(const TileRenderParts& parts) : parts_(parts) {}

  /// Adds the samples to the film. A set `stop` ends every tile after its present pixel row; what
  /// was sampled is kept. Adaptive samplers take whole rounds: the range must be one. `onTile` is
  /// called after each merged tile with the share that is done, from one thread at a time, with the
  /// statistics so far (stats included).
  /// Returns whether the whole range was rendered.
  bool render(SampleRange range, const std::atomic<bool>& stop, Stats& stats,
              const std::function<void(double share, const Stats& stats)>& onTile) override;

 private:
  struct Tile;
  struct Run;
  Bounds2i tileSamples(std::int64_t tile) const;
  void renderTile(Tile& tile, const Run& run) const;
  void renderPixel(Vec2i pixel, PixelSampler& pixelSampler, Tile& tile, const Run& run) const;
  void refinePixel(Vec2i pixel, int count, PixelSampler& pixelSampler, Tile& tile) const;
  Rgb sampleRadiance(const CameraSample& sample, RenderContext& context, LayerSample* layers) const;
  bool hasLayers() const { return parts_.scene && parts_.film.settings().withLayers; }

  TileRenderParts parts_;
};

}  // namespace brume
