// SPDX-License-Identifier: Apache-2.0
#include "transport/camera_beams.h"

#include "core/camera.h"
#include "core/film.h"
#include "core/parallel.h"
#include "transport/surface_photon_map.h"

namespace brume {
namespace {

constexpr int kTileSize = 16;  // pixels

/// One tile's part of the pass.
struct TileBeams {
  Bounds2i pixels;
  std::vector<CameraBeams::Sample> samples;
  OwnedBeams primary, secondary;
  Stats stats;
};

/// Keeps the beams of one camera path and adds the light of surface photons.
class BeamCollector final : public CameraPathVisitor {
 public:
  BeamCollector(const CameraBeamOptions& options, TileBeams& tile, std::uint32_t pixel)
      : options_(options), tile_(tile), pixel_(pixel) {}

  void onSegment(const MediumAlongRay& medium, const Rgb& weight, int bounces) override {
    const Ray& ray = medium.ray();
    const Interval range = medium.range();
    OwnedBeams& to = bounces == 0 ? tile_.primary : tile_.secondary;
    const float radius =
        options_.pixelRadii.empty() ? options_.beamRadius : options_.pixelRadii[pixel_];
    if (to.beams.empty()) to.reserve(static_cast<std::size_t>(tile_.pixels.area()));
    to.beams.push_back({ray.o, range.t0, ray.d, range.t1, radius, pixel_});
    to.owners.push_back({static_cast<std::uint32_t>(tile_.samples.size()), weight, ray.time});
  }
  void onSurface(const SurfaceInteraction& at, const Bsdf& bsdf, const Rgb& weight) override {
    if (options_.surface)
      L += weight * options_.surface->radiance(at, bsdf, options_.surfaceRadius);
  }

  Rgb L;

 private:
  const CameraBeamOptions& options_;
  TileBeams& tile_;
  std::uint32_t pixel_;
};

void traceTile(const PassContext& context, const CameraPaths& paths,
               const CameraBeamOptions& options, const Bounds2i& all, TileBeams& tile) {
  const std::unique_ptr<PixelSampler> sampler = context.sampler.makePixelSampler(context.seed);
  RenderContext render{*sampler, tile.stats};
  tile.samples.reserve(static_cast<std::size_t>(tile.pixels.area()));
  for (int y = tile.pixels.lo.y; y < tile.pixels.hi.y; ++y)
    for (int x = tile.pixels.lo.x; x < tile.pixels.hi.x; ++x) {
      sampler->startPixel({x, y});
      CameraSample sample = sampler->startSample(static_cast<int>(context.pass));
      if (options.throughCentres) sample.raster = Vec2(x, y) + Vec2(0.5f);
      if (options.moment) sample.time = *options.moment;
      FootprintRay ray = context.camera.generateRay(sample);
      if (!context.footprints) ray.differential.reset();
      tile.stats.add(Stat::CameraRays);
      const auto pixel = static_cast<std::uint32_t>((y - all.lo.y) * all.width() + (x - all.lo.x));
      BeamCollector collector(options, tile, pixel);
      const Rgb L = paths.follow(ray, collector, render) + collector.L;
      tile.samples.push_back({sample.raster, tile.stats.checkRadiance(L)});
    }
}

}  // namespace

void addToFilm(const CameraBeams& beams, Film& film) {
  // A batch of tiles at a time, so that few wait for their turn.
  constexpr std::size_t kBatch = 256;
  for (std::size_t first = 0; first < beams.tiles.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, beams.tiles.size() - first);
    std::vector<std::optional<FilmTile>> done(count);
    forEachChunk(static_cast<std::int64_t>(count), 1,
                 [&](std::int64_t, std::int64_t, std::int64_t i) {
                   const CameraBeams::Tile& tile = beams.tiles[first + static_cast<std::size_t>(i)];
                   FilmTile filmTile = film.makeTileOfPass(tile.pixels);
                   for (std::size_t s = tile.first; s < tile.end; ++s)
                     filmTile.addSample(beams.samples[s].raster, beams.samples[s].L);
                   done[static_cast<std::size_t>(i)].emplace(std::move(filmTile));
                 });
    for (const auto& tile : done) film.mergeIntoPass(*tile);
  }
  film.endPass();
}

CameraBeams traceCameraBeams(const PassContext& context, const CameraPaths& paths,
                             const CameraBeamOptions& options) {
  const Bounds2i all = context.film.sampleBounds();
  const auto tilesAlong = [](int n) { return (n + kTileSize - 1) / kTileSize; };
  const std::int64_t perRow = tilesAlong(all.width()), count = perRow * tilesAlong(all.height());
  std::vector<TileBeams> tiles(static_cast<std::size_t>(count));
  forEachChunk(count, 1, [&](std::int64_t i, std::int64_t, std::int64_t) {
    if (context.stop.load(std::memory_order_relaxed)) return;
    const Vec2i lo = all.lo + kTileSize * Vec2i(i % perRow, i / perRow);
    TileBeams& tile = tiles[static_cast<std::size_t>(i)];
    tile.pixels = {lo,
                   {std::min(lo.x + kTileSize, all.hi.x), std::min(lo.y + kTileSize, all.hi.y)}};
    traceTile(context, paths, options, all, tile);
  });

  CameraBeams result;
  result.pixels = all;
  if (context.stop.load(std::memory_order_relaxed)) return result;
  // Room for all at once: arrays that grow leave holes, and the memory of many passes would creep
  // up.
  std::size_t samples = 0, primary = 0, secondary = 0;
  for (const TileBeams& tile : tiles) {
    samples += tile.samples.size();
    primary += tile.primary.beams.size();
    secondary += tile.secondary.beams.size();
  }
  result.samples.reserve(samples);
  result.tiles.reserve(tiles.size());
  result.primary.reserve(primary);
  result.secondary.reserve(secondary);
  for (TileBeams& tile : tiles) {
    const auto first = static_cast<std::uint32_t>(result.samples.size());
    for (OwnedBeams* beams : {&tile.primary, &tile.secondary})
      for (BeamOwner& owner : beams->owners) owner.sample += first;
    result.samples.insert(result.samples.end(), tile.samples.begin(), tile.samples.end());
    result.tiles.push_back({tile.pixels, first, result.samples.size()});
    result.primary.append(tile.primary);
    result.secondary.append(tile.secondary);
    context.stats.merge(tile.stats);
    tile = {};
  }
  return result;
}

}  // namespace brume
