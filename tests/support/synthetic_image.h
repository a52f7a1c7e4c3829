// SPDX-License-Identifier: Apache-2.0
// The image side without a scene: independent random samples, a camera that only passes on raster
// positions, and a box filter.
#pragma once

#include "core/camera.h"
#include "core/filter.h"
#include "core/rng.h"
#include "core/sampler.h"

namespace brume {

/// Half-width `r` pixels, weight 1.
class TestBoxFilter final : public Filter {
 public:
  explicit TestBoxFilter(float r) : radius_(r) {}
  Vec2 radius() const override { return Vec2(radius_); }
  float weightX(float dx) const override { return std::abs(dx) <= radius_ ? 1.f : 0.f; }
  float weightY(float dy) const override { return weightX(dy); }

 private:
  float radius_;
};

/// The ray's origin is (raster x, raster y, time).
class RasterCamera final : public Camera {
 public:
  RasterCamera() : Camera(CameraParams{}, FactoryContext{}) {}
  FootprintRay generateRay(const CameraSample& sample) const override {
    Ray ray;
    ray.o = {sample.raster.x, sample.raster.y, sample.time};
    return FootprintRay(ray);
  }
};

/// Independent uniform numbers; counts may differ between pixels as with bestcandidate.
class TestSampler final : public Sampler {
 public:
  struct Options {
    int samplesPerPixel = 4;
    bool uneven = false;  ///< odd pixels take one sample more, even ones one less
    int refined = 0;      ///< adaptive when not 0: the count that replaces the first one
  };
  explicit TestSampler(const Options& options) : options_(options) {}
  int samplesPerPixel() const override { return options_.samplesPerPixel; }
  bool isAdaptive() const override { return options_.refined != 0; }
  std::unique_ptr<PixelSampler> makePixelSampler(std::uint64_t seed) const override {
    return std::make_unique<Stream>(seed, options_);
  }

 private:
  class Stream final : public PixelSampler {
   public:
    Stream(std::uint64_t seed, const Options& options) : seed_(seed), options_(options) {}
    int startPixel(Vec2i pixel) override {
      pixel_ = pixel;
      refined_ = false;
      const int odd = (pixel.x + pixel.y) & 1;
      return options_.samplesPerPixel + (options_.uneven ? (odd ? 1 : -1) : 0);
    }
    CameraSample startSample(int index) override {
      rng_ = Rng(hashIntegers(seed_, pixel_.x, pixel_.y, index, refined_));
      CameraSample sample;
      sample.raster = Vec2(pixel_) + rng_.uniform2();
      sample.time = rng_.uniform();
      return sample;
    }
    int refine(std::span<const Rgb>) override {
      if (refined_) return 0;
      refined_ = true;
      return options_.refined;
    }
    float get1D() override { return rng_.uniform(); }
    Vec2 get2D() override { return rng_.uniform2(); }
    void get1DArray(std::span<float> values) override {
      for (float& v : values) v = rng_.uniform();
    }
    void get2DArray(std::span<Vec2> values) override {
      for (Vec2& v : values) v = rng_.uniform2();
    }

   private:
    std::uint64_t seed_;
    const Options& options_;
    Vec2i pixel_{0};
    bool refined_ = false;
    Rng rng_;
  };
  Options options_;
};

}  // namespace brume
