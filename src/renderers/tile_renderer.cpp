// SPDX-License-Identifier: Apache-2.0
#include "renderers/tile_renderer.h"

#include <condition_variable>
#include <exception>
#include <limits>
#include <map>
#include <memory>
#include <mutex>

#include "core/parallel.h"
#include "core/rng.h"
#include "core/tracking_key.h"
#include "renderers/first_hit.h"

namespace brume {
namespace {

/// A tile may be begun this far ahead of the first one that is not merged.
constexpr std::int64_t kMaxTilesAhead = 512;

/// The tiles that are finished before their turn, and where they go to.
class InOrder {
 public:
  InOrder(Film& film, Stats& stats) : film_(film), stats_(stats) {}

  /// Waits until tile `index` is near enough to the first one that is not merged. That one's thread
  /// never waits, so all go on. False: a tile before this one has failed.
  bool waitForTurn(std::int64_t index) {
    std::unique_lock lock(mutex_);
    moved_.wait(lock, [&] { return failed_ < index || index < next_ + kMaxTilesAhead; });
    return index < failed_;
  }
  /// Counts the tile's statistics; merges it, and all that waited for it, when it is its turn.
  /// Calls merged(n), n the number of merged tiles, from one thread at a time.
  template <class Merged>
  void add(std::int64_t index, FilmTile tile, const Stats& tileStats, Merged&& merged) {
    const std::lock_guard lock(mutex_);
    stats_.merge(tileStats);
    waiting_.emplace(index, std::move(tile));
    for (auto it = waiting_.begin(); it != waiting_.end() && it->first == next_;
         it = waiting_.erase(it)) {
      film_.merge(it->second);
      ++next_;
    }
    merged(next_);
    moved_.notify_all();
  }
  /// Ends the tiles after this one, which cannot be merged, and keeps the present exception. Those
  /// before it go on, so that the failure of the first tile to fail is the one that is told,
  /// whatever the number of threads.
  void fail(std::int64_t index) {
    const std::lock_guard lock(mutex_);
    if (index >= failed_) return;
    failed_ = index;
    failure_ = std::current_exception();
    moved_.notify_all();
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  Film& film_;
  Stats& stats_;
  std::mutex mutex_;
  std::condition_variable moved_;
  std::map<std::int64_t, FilmTile> waiting_;
  std::int64_t next_ = 0;
  std::int64_t failed_ = std::numeric_limits<std::int64_t>::max();
  std::exception_ptr failure_;
};

/// Of one pixel, where an average pixel has n. Only the first round may differ from pixel to pixel:
/// a filter that reaches beyond its pixel would for ever see more of those with more samples.
std::int64_t samplesBefore(std::int64_t n, std::int64_t firstRound, std::int64_t average) {
  return n < average ? n * firstRound / average : firstRound + (n - average);
}

}  // namespace

/// One tile in work, private to its thread.
struct TileRenderer::Tile {
  Bounds2i samples;
  FilmTile film;
  Stats stats;
};

/// What all tiles of one call have in common.
struct TileRenderer::Run {
  SampleRange range;
  const std::atomic<bool>& stop;
  std::int64_t round = 0;  ///< of an adaptive sampler, which begins anew in each
};

Bounds2i TileRenderer::tileSamples(std::int64_t tile) const {
  const Bounds2i all = parts_.film.sampleBounds();
  const std::int64_t perRow = (all.width() + kTileSize - 1) / kTileSize;
  const Vec2i lo = all.lo + kTileSize * Vec2i(tile % perRow, tile / perRow);
  return {lo, {std::min(lo.x + kTileSize, all.hi.x), std::min(lo.y + kTileSize, all.hi.y)}};
}

bool TileRenderer::render(SampleRange range, const std::atomic<bool>& stop, Stats& stats,
                          const std::function<void(double, const Stats&)>& onTile) {
  const Bounds2i all = parts_.film.sampleBounds();
  const auto tilesAlong = [](int pixels) { return (pixels + kTileSize - 1) / kTileSize; };
  const std::int64_t count = std::int64_t{tilesAlong(all.width())} * tilesAlong(all.height());
  const Run run{range, stop, range.first / parts_.sampler.samplesPerPixel()};

  std::atomic<std::int64_t> next{0};
  InOrder inOrder(parts_.film, stats);
  // The loop serves as a pool of threads; the tiles are taken from a common counter, in order.
  forEachChunk(count, 1, [&](std::int64_t, std::int64_t, std::int64_t) {
    const std::int64_t index = next.fetch_add(1);
    try {
      if (!inOrder.waitForTurn(index)) return;
      const Bounds2i samples = tileSamples(index);
      Tile tile{samples, parts_.film.makeTile(samples), {}};
      renderTile(tile, run);
      inOrder.add(index, std::move(tile.film), tile.stats, [&](std::int64_t merged) {
        onTile(static_cast<double>(merged) / static_cast<double>(count), stats);
      });
    } catch (...) {
      inOrder.fail(index);
    }
  });
  inOrder.rethrow();
  return !stop.load(std::memory_order_relaxed);
}

void TileRenderer::renderTile(Tile& tile, const Run& run) const {
  const bool isAdaptive = parts_.sampler.isAdaptive();
  // An adaptive sampler has no samples beyond a round: each round is another seed's.
  const std::uint64_t seed =
      isAdaptive && run.round > 0 ? hashIntegers(parts_.seed, run.round) : parts_.seed;
  const std::unique_ptr<PixelSampler> pixelSampler = parts_.sampler.makePixelSampler(seed);
  for (int y = tile.samples.lo.y; y < tile.samples.hi.y; ++y) {
    if (run.stop.load(std::memory_order_relaxed)) return;
    for (int x = tile.samples.lo.x; x < tile.samples.hi.x; ++x)
      renderPixel({x, y}, *pixelSampler, tile, run);
  }
}

void TileRenderer::renderPixel(Vec2i pixel, PixelSampler& pixelSampler, Tile& tile,
                               const Run& run) const {
  const int perRound = pixelSampler.startPixel(pixel);
  if (parts_.sampler.isAdaptive()) return refinePixel(pixel, perRound, pixelSampler, tile);
  const std::int64_t average = parts_.sampler.samplesPerPixel();
  const auto first = static_cast<int>(samplesBefore(run.range.first, perRound, average));
  const auto end = static_cast<int>(samplesBefore(run.range.end, perRound, average));
  RenderContext context{pixelSampler, tile.stats};
  for (int i = first; i < end; ++i) {
    const TrackingKeyScope key(hashIntegers(parts_.seed, pixel.x, pixel.y, i));
    const CameraSample sample = pixelSampler.startSample(i);
    if (!hasLayers()) {
      tile.film.addSample(sample.raster, sampleRadiance(sample, context, nullptr));
      continue;
    }
    LayerSample layers;
    const Rgb L = sampleRadiance(sample, context, &layers);
    tile.film.addSample(sample.raster, L, &layers);
  }
}

void TileRenderer::refinePixel(Vec2i pixel, int count, PixelSampler& pixelSampler,
                               Tile& tile) const {
  RenderContext context{pixelSampler, tile.stats};
  std::vector<Vec2> rasters;
  std::vector<Rgb> values;
  std::vector<LayerSample> layers;
  while (count > 0) {
    rasters.clear();
    values.clear();
    layers.clear();
    for (int i = 0; i < count; ++i) {
      const TrackingKeyScope key(hashIntegers(parts_.seed, pixel.x, pixel.y, i));
      const CameraSample sample = pixelSampler.startSample(i);
      rasters.push_back(sample.raster);
      if (hasLayers()) layers.emplace_back();
      values.push_back(sampleRadiance(sample, context, hasLayers() ? &layers.back() : nullptr));
    }
    count = pixelSampler.refine(values);
  }
  for (std::size_t i = 0; i < values.size(); ++i)
    tile.film.addSample(rasters[i], values[i], layers.empty() ? nullptr : &layers[i]);
}

Rgb TileRenderer::sampleRadiance(const CameraSample& sample, RenderContext& context,
                                 LayerSample* layers) const {
  FootprintRay ray = parts_.camera.generateRay(sample);
  if (parts_.footprints)
    ray.scaleDifferential(1.f / std::sqrt(static_cast<float>(parts_.sampler.samplesPerPixel())));
  else
    ray.differential.reset();
  context.stats.add(Stat::CameraRays);
  if (!layers) return context.stats.checkRadiance(parts_.radiance.Li(ray, 0, context));

  if (parts_.radiance.splitsComponents()) context.components = &layers->components.emplace();
  const Rgb L = parts_.radiance.Li(ray, 0, context);
  context.components = nullptr;
  // What the film does not take for colour, it takes for no layer either.
  if (!L.isFinite() && layers->components) layers->components.emplace();
  describeFirstHit(*parts_.scene, ray, *layers, context.stats);
  return context.stats.checkRadiance(L);
}

}  // namespace brume
