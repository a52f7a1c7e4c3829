// SPDX-License-Identifier: Apache-2.0
#include "core/error.h"
#include "core/medium_along_ray.h"
#include "core/volume.h"

namespace brume {

namespace {

/// The sum of several volumes: coefficients add up where they overlap, and what one of them emits
/// is attenuated by all. Source: PBRT-v2. Test: aggregate_test.
class Aggregate final : public Volume {
 public:
  explicit Aggregate(std::vector<const Volume*> volumes) : volumes_(std::move(volumes)) {
    for (const Volume* v : volumes_) bounds_.extend(v->bounds());
  }

  Bounds3 bounds() const override { return bounds_; }

  std::optional<Interval> intersect(const Ray& ray) const override {
    std::optional<Interval> hull;
    for (const Volume* v : volumes_)
      if (const auto r = v->intersect(ray))
        hull = hull ? Interval{std::min(hull->t0, r->t0), std::max(hull->t1, r->t1)} : *r;
    return hull;
  }

  MediumCoefficients at(const Vec3& p) const override {
    MediumCoefficients sum;
    for (const Volume* v : volumes_) sum += v->at(p);
    return sum;
  }

  Rgb majorant() const override {
    Rgb sum;
    for (const Volume* v : volumes_) sum += v->majorant();
    return sum;
  }

  Rgb opticalDepth(const Ray& ray, Interval range) const override {
    Rgb sum;
    for (const Volume* v : volumes_) sum += v->opticalDepth(ray, range);
    return sum;
  }

  std::optional<float> invertOpticalDepth(const Ray& ray, Interval range, int channel,
                                          float depth) const override {
    if (depth <= 0) return range.t0;
    return lookUp(ray, range).invert(channel, double{depth});
  }

  Rgb emission(const Ray& ray, Interval range) const override {
    return isEmissive() ? lookUp(ray, range).emission() : Rgb();
  }

  void appendPieces(const Ray& ray, Interval range,
                    std::vector<MediumPiece>& pieces) const override {
    for (const Volume* v : volumes_) v->appendPieces(ray, range, pieces);
  }

  bool isClosedForm() const override {
    return volumes_.size() <= 4 && std::all_of(volumes_.begin(), volumes_.end(),
                                               [](const Volume* v) { return v->isClosedForm(); });
  }
  bool isEmissive() const override {
    return std::any_of(volumes_.begin(), volumes_.end(),
                       [](const Volume* v) { return v->isEmissive(); });
  }
  bool isScattering() const override {
    return std::any_of(volumes_.begin(), volumes_.end(),
                       [](const Volume* v) { return v->isScattering(); });
  }

  float phase(const Vec3& p, const Vec3& wo, const Vec3& wi) const override {
    float sum = 0, weights = 0;
    for (const Volume* v : volumes_) {
      const float weight = v->at(p).sigma_s.luminance();
      if (weight <= 0) continue;
      sum += weight * v->phase(p, wo, wi);
      weights += weight;
    }
    return weights > 0 ? sum / weights : volumes_.front()->phase(p, wo, wi);
  }

  PhaseSample samplePhase(const Vec3& p, const Vec3& wo, float uComponent, Vec2 u) const override {
    float total = 0;
    for (const Volume* v : volumes_) total += v->at(p).sigma_s.luminance();
    if (total <= 0) return volumes_.front()->samplePhase(p, wo, uComponent, u);

    // One volume by its share, its own lobe by the rest of the random number.
    float rest = uComponent * total;
    const Volume* chosen = nullptr;
    float chosenWeight = 0, offset = 0;
    for (const Volume* v : volumes_) {
      const float weight = v->at(p).sigma_s.luminance();
      if (weight <= 0) continue;
      chosen = v;
      chosenWeight = weight;
      offset = rest;
      if (rest < weight) break;
      rest -= weight;
    }
    PhaseSample sample =
        chosen->samplePhase(p, wo, std::clamp(offset / chosenWeight, 0.f, kOneMinusEpsilon), u);
    sample.value = sample.pdf = phase(p, wo, sample.wi);
    return sample;
  }

  float phasePeak() const override {
    float peak = 0;
    for (const Volume* v : volumes_)
      if (v->isScattering()) peak = std::max(peak, v->phasePeak());
    return peak;
  }

 private:
  /// Kept per thread, so that its memory is reused from call to call.
  static const MediumAlongRay& lookUpIn(const Aggregate& self, const Ray& ray, Interval range) {
    thread_local MediumAlongRay record;
    record.assign(self, ray, range);
    return record;
  }
  const MediumAlongRay& lookUp(const Ray& ray, Interval range) const {
    return lookUpIn(*this, ray, range);
  }

  std::vector<const Volume*> volumes_;
  Bounds3 bounds_;
};

}  // namespace

std::unique_ptr<Volume> makeAggregateVolume(std::vector<const Volume*> volumes) {
  BRUME_CHECK(!volumes.empty());
  return std::make_unique<Aggregate>(std::move(volumes));
}

}  // namespace brume
