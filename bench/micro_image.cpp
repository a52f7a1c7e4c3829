// SPDX-License-Identifier: Apache-2.0
// From sample positions to the image file: samplers, filters, EXR.
#include <benchmark/benchmark.h>

#include <filesystem>

#include "core/film.h"
#include "core/rng.h"
#include "core/sampler.h"
#include "support/make_plugin.h"

namespace brume::bench {
namespace {

/// Camera samples of which each asks for eight pairs of numbers, pixel after pixel.
void samplerGet2D(benchmark::State& state, const char* name) {
  constexpr int kPairs = 8, kImage = 64;
  Sampler::FactoryContext context;
  context.pixels = {{0, 0}, {kImage, kImage}};
  const auto sampler = test::make<Sampler>(name, {}, context);
  const auto stream = sampler->makePixelSampler(1);
  int pixel = 0, index = 0, count = 0;
  for (auto _ : state) {
    if (index == count) {
      count = stream->startPixel({pixel % kImage, pixel / kImage});
      pixel = (pixel + 1) % (kImage * kImage);
      index = 0;
    }
    benchmark::DoNotOptimize(stream->startSample(index++));
    for (int i = 0; i < kPairs; ++i) benchmark::DoNotOptimize(stream->get2D());
  }
  state.SetItemsProcessed(state.iterations() * kPairs);
}
BENCHMARK_CAPTURE(samplerGet2D, lowdiscrepancy, "lowdiscrepancy");
BENCHMARK_CAPTURE(samplerGet2D, stratified, "stratified");
BENCHMARK_CAPTURE(samplerGet2D, halton, "halton");
BENCHMARK_CAPTURE(samplerGet2D, random, "random");
BENCHMARK_CAPTURE(samplerGet2D, bestcandidate, "bestcandidate");
BENCHMARK_CAPTURE(samplerGet2D, adaptive, "adaptive");

/// Samples all over a tile, with the filter's default width.
void filmAddSample(benchmark::State& state, const char* name) {
  constexpr int kTile = 16;
  const auto filter = test::make<Filter>(name, {});
  FilmTile tile({{0, 0}, {kTile, kTile}}, *filter, false, false);
  Rng rng(1);
  for (auto _ : state) {
    tile.addSample(rng.uniform2() * float(kTile), Rgb(1, 2, 3));
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK_CAPTURE(filmAddSample, box, "box");
BENCHMARK_CAPTURE(filmAddSample, triangle, "triangle");
BENCHMARK_CAPTURE(filmAddSample, gaussian, "gaussian");
BENCHMARK_CAPTURE(filmAddSample, mitchell, "mitchell");
BENCHMARK_CAPTURE(filmAddSample, sinc, "sinc");

/// A noisy image of 1024 x 1024 pixels, compressed, written and flushed to the disk.
void writeExrFile(benchmark::State& state, PixelPrecision precision) {
  constexpr int kSide = 1024;
  LayeredImage image;
  image.displaySize = {kSide, kSide};
  image.dataWindow = {{0, 0}, {kSide, kSide}};
  Rng rng(1);
  for (const char* channel : {"R", "G", "B"}) {
    auto& values = image.channels[channel];
    values.resize(kSide * kSide);
    for (float& v : values) v = 1 + rng.uniform();
  }
  const auto path = std::filesystem::temp_directory_path() / "brume_micro.exr";
  for (auto _ : state) writeImage(path.string(), image, precision);
  std::filesystem::remove(path);
  state.SetItemsProcessed(state.iterations() * kSide * kSide);
}
BENCHMARK_CAPTURE(writeExrFile, half, PixelPrecision::Half)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(writeExrFile, float, PixelPrecision::Float)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace brume::bench
