// SPDX-License-Identifier: Apache-2.0
#include "core/error.h"
#include "core/medium_along_ray.h"
#include "core/volume.h"

namespace brume {

namespace {

/// The sum of several volumes: coefficients add up where they overlap, what one of them emits is
/// attenuated by all, and each scatters by its own phase function: sigma_s p = sum_k sigma_s,k p_k
/// in every channel (PBRT-v2 weights the p_k by luminance). Test: volumes_test, volpath_test.
class Aggregate final : public Volume {
 public:
  explicit Aggregate(std::vector<const Volume*> volumes) : volumes_(std::move(volumes)) {
    for (const Volume* v : volumes_) bounds_.extend(v->bounds());
  }

  Bounds3 bounds() const override { return bounds_; }

  void appendBoxes(std::vector<MediumBox>& boxes) const override {
    for (const Volume* v : volumes_) v->appendBoxes(boxes);
  }

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

  Rgb totalEmission() const override {
    Rgb sum;
    for (const Volume* v : volumes_) sum += v->totalEmission();
    return sum;
  }

  Vec3 sampleEmission(Rng& rng) const override {
    // One volume by its share.
    double rest = rng.uniformDouble() * double{totalEmission().luminance()};
    const Volume* chosen = nullptr;
    for (const Volume* v : volumes_) {
      if (!v->isEmissive()) continue;
      chosen = v;
      rest -= double{v->totalEmission().luminance()};
      if (rest < 0) break;
    }
    return chosen->sampleEmission(rng);
  }

  void appendPieces(const Ray& ray, Interval range,
                    std::vector<MediumPiece>& pieces) const override {
    for (const Volume* v : volumes_) v->appendPieces(ray, range, pieces);
  }

  bool isClosedForm() const override {
    return volumes_.size() <= 4 && std::all_of(volumes_.begin(), volumes_.end(),
                                               [](const Volume* v) { return v->isClosedForm(); });
  }
  bool isTracked() const override {
    return std::any_of(volumes_.begin(), volumes_.end(),
                       [](const Volume* v) { return v->isTracked(); });
  }
  bool isEmissive() const override {
    return std::any_of(volumes_.begin(), volumes_.end(),
                       [](const Volume* v) { return v->isEmissive(); });
  }
  bool isScattering() const override {
    return std::any_of(volumes_.begin(), volumes_.end(),
                       [](const Volume* v) { return v->isScattering(); });
  }

  Rgb phase(const Vec3& p, const Vec3& wo, const Vec3& wi) const override {
    const Rgb total = at(p).sigma_s;
    if (total.isBlack()) return volumes_.front()->phase(p, wo, wi);
    Rgb sum;
    for (const Volume* v : volumes_) {
      const Rgb share = shareOf(v->at(p).sigma_s, total);
      if (!share.isBlack()) sum += share * v->phase(p, wo, wi);
    }
    return sum;
  }

  bool appendLobes(const Vec3& p, std::vector<PhaseLobe>& lobes) const override {
    const std::size_t before = lobes.size();
    const Rgb total = at(p).sigma_s;
    for (const Volume* v : volumes_) {
      const auto g = v->henyeyGreenstein();
      if (!g) {
        lobes.resize(before);
        return false;
      }
      const Rgb share = total.isBlack() ? Rgb(v == volumes_.front() ? 1.f : 0.f)
                                        : shareOf(v->at(p).sigma_s, total);
      if (!share.isBlack()) lobes.push_back({*g, share});
    }
    return true;
  }

  ScatterSample samplePhase(const Vec3& p, const Vec3& wo, const Rgb& carried, float uComponent,
                            Vec2 u) const override {
    const Rgb total = at(p).sigma_s;
    if (total.isBlack()) return volumes_.front()->samplePhase(p, wo, carried, uComponent, u);

    // One volume by its share of what is carried, its own lobe by the rest of the random number.
    float rest = uComponent, offset = 0, chosenWeight = 1;
    const Volume* chosen = nullptr;
    for (const Volume* v : volumes_) {
      const float weight = phasePdf(shareOf(v->at(p).sigma_s, total), carried);
      if (!(weight > 0)) continue;
      chosen = v;
      chosenWeight = weight;
      offset = rest;
      if (rest < weight) break;
      rest -= weight;
    }
    if (!chosen) return {};
    ScatterSample sample = chosen->samplePhase(
        p, wo, carried, std::clamp(offset / chosenWeight, 0.f, kOneMinusEpsilon), u);
    sample.value = phase(p, wo, sample.wi);
    sample.pdf = phasePdf(sample.value, carried);
    return sample;
  }

  float phasePeak() const override {
    float peak = 0;
    for (const Volume* v : volumes_)
      if (v->isScattering()) peak = std::max(peak, v->phasePeak());
    return peak;
  }

 private:
  /// A volume's share of the scattering in each channel; in channels that do not scatter, of all.
  static Rgb shareOf(const Rgb& sigma_s, const Rgb& total) {
    const float ofAll = sigma_s.average() / total.average();
    return {total.r > 0 ? sigma_s.r / total.r : ofAll, total.g > 0 ? sigma_s.g / total.g : ofAll,
            total.b > 0 ? sigma_s.b / total.b : ofAll};
  }
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
