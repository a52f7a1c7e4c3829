// SPDX-License-Identifier: Apache-2.0
#include "transport/camera_beams.h"

#include <cmath>

#include "core/camera.h"
#include "core/film.h"
#include "core/parallel.h"
#include "transport/surface_photon_map.h"

namespace brume {
namespace {

constexpr int kTileSize = 16;  // pixels

/// One tile's part of the pass. Samples and primary beams, one at most for each sample, stand in
/// the tile's part of the pass's arrays, from `first` on: arrays for each tile would need the
/// memory twice, in pieces.
struct TileBeams {
  Bounds2i pixels;
  std::size_t first = 0;
  std::size_t samples = 0, primary = 0;  // so far
  OwnedBeams secondary;
  Stats stats;
};

/// Keeps the beams of one camera path and adds the light of surface photons.
class BeamCollector final : public CameraPathVisitor {
 public:
  BeamCollector(const CameraBeamOptions& options, CameraBeams& pass, TileBeams& tile,
                std::uint32_t pixel)
      : options_(options), pass_(pass), tile_(tile), pixel_(pixel) {}

  void onSegment(const MediumAlongRay& medium, const Rgb& weight, int bounces) override {
    if (!options_.wantsBeams) return;
    const Ray& ray = medium.ray();
    const Interval range = medium.range();
    const float radius =
        options_.pixelRadii.empty() ? options_.beamRadius : options_.pixelRadii[pixel_];
    const Beam beam{ray.o, range.t0, ray.d, range.t1, radius, pixel_};
    const BeamOwner owner{static_cast<std::uint32_t>(tile_.first + tile_.samples), weight,
                          ray.time};
    if (bounces == 0) {
      const std::size_t at = tile_.first + tile_.primary++;
      pass_.primary.beams[at] = beam;
      pass_.primary.owners[at] = owner;
    } else {
      tile_.secondary.beams.push_back(beam);
      tile_.secondary.owners.push_back(owner);
    }
  }
  void onSurface(const SurfaceInteraction& at, const Bsdf& bsdf, const Rgb& weight) override {
    if (options_.surface)
      L += weight * options_.surface->radiance(at, bsdf, options_.surfaceRadius);
  }

  Rgb L;

 private:
  const CameraBeamOptions& options_;
  CameraBeams& pass_;
  TileBeams& tile_;
  std::uint32_t pixel_;
};

void traceTile(const PassContext& context, const CameraPaths& paths,
               const CameraBeamOptions& options, CameraBeams& pass, TileBeams& tile) {
  const Bounds2i& all = pass.pixels;
  const std::unique_ptr<PixelSampler> sampler = context.sampler.makePixelSampler(context.seed);
  RenderContext render{*sampler, tile.stats};
  const float footprintScale =
      1.f / std::sqrt(static_cast<float>(context.sampler.samplesPerPixel()));
  for (int y = tile.pixels.lo.y; y < tile.pixels.hi.y; ++y)
    for (int x = tile.pixels.lo.x; x < tile.pixels.hi.x; ++x) {
      sampler->startPixel({x, y});
      CameraSample sample = sampler->startSample(static_cast<int>(context.pass));
      if (options.throughCentres) sample.raster = Vec2(x, y) + Vec2(0.5f);
      if (options.moment) sample.time = *options.moment;
      FootprintRay ray = context.camera.generateRay(sample);
      // Textures are filtered as other integrators filter them at the scene's samples per pixel.
      if (context.footprints)
        ray.scaleDifferential(footprintScale);
      else
        ray.differential.reset();
      tile.stats.add(Stat::CameraRays);
      const auto pixel = static_cast<std::uint32_t>((y - all.lo.y) * all.width() + (x - all.lo.x));
      BeamCollector collector(options, pass, tile, pixel);
      const Rgb L = tile.stats.checkRadiance(paths.follow(ray, collector, render) + collector.L);
      if (options.monitor)
        if (const auto probe = options.monitor->probeOf({x, y}))
          pass.probes[*probe] = {static_cast<std::uint32_t>(tile.first + tile.samples), L,
                                 collector.L.isFinite() ? collector.L : Rgb()};
      pass.samples[tile.first + tile.samples++] = {sample.raster, L};
    }
}

}  // namespace

std::vector<ProbeLight> probeLight(const CameraBeams& beams) {
  std::vector<ProbeLight> light;
  light.reserve(beams.probes.size());
  for (const CameraBeams::Probe& probe : beams.probes) {
    const Rgb all = beams.samples[probe.sample].L;
    light.push_back({{all - probe.beforeBeams, probe.surfaces}, all});
  }
  return light;
}

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

namespace {

/// The tiles of the image, with their places in the pass's arrays.
std::vector<TileBeams> tilesOf(const Bounds2i& all) {
  std::vector<TileBeams> tiles;
  std::size_t first = 0;
  for (int y = all.lo.y; y < all.hi.y; y += kTileSize)
    for (int x = all.lo.x; x < all.hi.x; x += kTileSize) {
      TileBeams& tile = tiles.emplace_back();
      tile.pixels = {{x, y},
                     {std::min(x + kTileSize, all.hi.x), std::min(y + kTileSize, all.hi.y)}};
      tile.first = first;
      first += static_cast<std::size_t>(tile.pixels.area());
    }
  return tiles;
}

}  // namespace

CameraBeams traceCameraBeams(const PassContext& context, const CameraPaths& paths,
                             const CameraBeamOptions& options, CameraBeams old) {
  CameraBeams result = std::move(old);
  result.pixels = context.film.sampleBounds();
  std::vector<TileBeams> tiles = tilesOf(result.pixels);
  const auto area = static_cast<std::size_t>(result.pixels.area());
  resizeForReuse(result.samples, area);
  result.primary.resize(options.wantsBeams ? area : 0);
  result.probes.assign(options.monitor ? options.monitor->probeCount() : 0, {});
  forEachChunk(static_cast<std::int64_t>(tiles.size()), 1,
               [&](std::int64_t i, std::int64_t, std::int64_t) {
                 if (context.stop.load(std::memory_order_relaxed)) return;
                 traceTile(context, paths, options, result, tiles[static_cast<std::size_t>(i)]);
               });
  if (context.stop.load(std::memory_order_relaxed)) return {};

  // The beams of all tiles move together.
  std::size_t primary = 0, secondary = 0;
  for (const TileBeams& tile : tiles) secondary += tile.secondary.beams.size();
  result.secondary.resize(secondary);
  result.tiles.clear();
  result.tiles.reserve(tiles.size());
  secondary = 0;
  for (TileBeams& tile : tiles) {
    result.tiles.push_back({tile.pixels, tile.first, tile.first + tile.samples});
    result.primary.move(tile.first, tile.primary, primary);
    primary += tile.primary;
    result.secondary.replace(secondary, tile.secondary);
    secondary += tile.secondary.beams.size();
    context.stats.merge(tile.stats);
    tile.secondary = {};
  }
  result.primary.resize(primary);
  return result;
}

}  // namespace brume
