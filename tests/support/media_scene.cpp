// SPDX-License-Identifier: Apache-2.0
#include "support/media_scene.h"

#include "core/sampling.h"

namespace brume::test {

namespace {

class TestPointLight final : public Light {
 public:
  explicit TestPointLight(const PointLightSpec& spec) : s_(spec) {}
  bool isDelta() const override { return true; }
  std::optional<LightSample> sampleLi(const Vec3& p, Vec2) const override {
    LightSample sample;
    sample.distance = distance(s_.from, p);
    sample.wi = (s_.from - p) / sample.distance;
    sample.p = s_.from;
    sample.pdf = 1;
    float f = 1;
    if (s_.cosTotal > -1) {
      const float c = dot(-sample.wi, s_.axis);
      if (c < s_.cosTotal) return std::nullopt;
      if (c < s_.cosStart) f = sqr(sqr((c - s_.cosTotal) / (s_.cosStart - s_.cosTotal)));
    }
    sample.L = s_.I * (f / sqr(sample.distance));
    return sample;
  }
  Rgb power() const override { return s_.I * (4 * kPi); }
  float importance(const Bounds3&) const override { return s_.I.maxChannel(); }
  std::optional<LightBounds> bounds() const override {
    return pointBounds(s_.from, s_.I.maxChannel());
  }
  std::optional<Vec3> position() const override { return s_.from; }

 private:
  PointLightSpec s_;
};

class TestDistantLight final : public Light {
 public:
  TestDistantLight(const Vec3& direction, Rgb L) : d_(normalize(direction)), L_(L) {}
  bool isDelta() const override { return true; }
  std::optional<LightSample> sampleLi(const Vec3&, Vec2) const override {
    LightSample s;
    s.L = L_;
    s.wi = -d_;
    s.pdf = 1;
    return s;
  }
  Rgb power() const override { return L_; }
  float importance(const Bounds3&) const override { return L_.maxChannel(); }

 private:
  Vec3 d_;
  Rgb L_;
};

class TestEnvironment final : public Light {
 public:
  explicit TestEnvironment(Rgb L) : L_(L) {}
  bool isDelta() const override { return false; }
  bool isInfinite() const override { return true; }
  std::optional<LightSample> sampleLi(const Vec3&, Vec2 u) const override {
    LightSample s;
    s.L = L_;
    s.wi = sampleUniformSphere(u);
    s.pdf = kInv4Pi;
    return s;
  }
  float pdfLi(const Vec3&, const Vec3&) const override { return kInv4Pi; }
  Rgb Le(const Ray&) const override { return L_; }
  Rgb power() const override { return L_; }
  float importance(const Bounds3&) const override { return L_.maxChannel(); }

 private:
  Rgb L_;
};

}  // namespace

std::unique_ptr<Light> makePointLight(const PointLightSpec& spec) {
  return std::make_unique<TestPointLight>(spec);
}
std::unique_ptr<Light> makeDistantLight(const Vec3& direction, Rgb L) {
  return std::make_unique<TestDistantLight>(direction, L);
}
std::unique_ptr<Light> makeEnvironment(Rgb L) { return std::make_unique<TestEnvironment>(L); }

Scene makeMediaScene(std::vector<std::unique_ptr<Volume>> volumes,
                     std::vector<std::unique_ptr<Light>> lights) {
  Scene::Contents contents;
  contents.volumes = std::move(volumes);
  contents.lights = std::move(lights);
  return Scene(std::move(contents));
}

void StratifiedStream::get1DArray(std::span<float> values) {
  const auto n = static_cast<std::uint32_t>(values.size());
  for (std::uint32_t i = 0; i < n; ++i)
    values[i] = std::min((float(i) + rng_.uniform()) / float(n), kOneMinusEpsilon);
  for (std::uint32_t i = n; i > 1; --i) std::swap(values[i - 1], values[rng_.below(i)]);
}

void StratifiedStream::get2DArray(std::span<Vec2> values) {
  const auto side = static_cast<std::uint32_t>(std::sqrt(float(values.size())));
  const auto n = static_cast<std::uint32_t>(values.size());
  for (std::uint32_t i = 0; i < n; ++i) {
    values[i] = rng_.uniform2();
    if (i < side * side)
      values[i] = (Vec2(float(i % side), float(i / side)) + values[i]) / float(side);
  }
  for (std::uint32_t i = n; i > 1; --i) std::swap(values[i - 1], values[rng_.below(i)]);
}

Estimate estimate(const VolumeIntegrator& integrator, const Ray& ray, int repeats,
                  std::uint64_t seed) {
  Estimate e;
  StratifiedStream stream(seed);
  RenderContext context{stream, e.stats};
  double sum[3] = {0, 0, 0}, squares[3] = {0, 0, 0};
  for (int i = 0; i < repeats; ++i) {
    const VolumeRadiance r = integrator.integrate(ray, context);
    e.Tr = r.Tr;
    for (int c = 0; c < 3; ++c) {
      sum[c] += double{r.Lv[c]};
      squares[c] += sqr(double{r.Lv[c]});
    }
  }
  for (int c = 0; c < 3; ++c) {
    e.mean[c] = sum[c] / repeats;
    e.variance[c] = std::max(0.0, squares[c] / repeats - sqr(e.mean[c]));
  }
  return e;
}

}  // namespace brume::test
