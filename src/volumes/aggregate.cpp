// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/error.h"
#include "core/medium_along_ray.h"
#include "core/volume.h"
#include "volumes/box_tree.h"

namespace brume {

namespace {

/// The sum of several volumes: coefficients add up where they overlap, what one of them emits is
/// attenuated by all, and each scatters by its own phase function: sigma_s p = sum_k sigma_s,k p_k
/// in every channel (PBRT-v2 weights the p_k by luminance). Test: volumes_test, volpath_test.
class Aggregate final : public Volume {
 public:
  explicit Aggregate(std::vector<const Volume*> volumes) : volumes_(std::move(volumes)) {
    std::vector<Bounds3> boxes;
    for (const Volume* v : volumes_) {
      boxes.push_back(v->bounds());
      bounds_.extend(boxes.back());
      majorant_ += v->majorant();
      isClosedForm_ &= v->isClosedForm();
      isTracked_ |= v->isTracked();
      isEmissive_ |= v->isEmissive();
      isScattering_ |= v->isScattering();
      hasLobes_ &= v->henyeyGreenstein().has_value();
      if (v->isScattering()) phasePeak_ = std::max(phasePeak_, v->phasePeak());
      const Rgb emission = v->totalEmission();
      totalEmission_ += emission;
      emissionSoFar_.push_back((emissionSoFar_.empty() ? 0 : emissionSoFar_.back()) +
                               (v->isEmissive() ? double{emission.luminance()} : 0));
    }
    if (volumes_.size() > kFew) tree_ = BoxTree(boxes);
  }

  Bounds3 bounds() const override { return bounds_; }

  void appendBoxes(std::vector<MediumBox>& boxes) const override {
    for (const Volume* v : volumes_) v->appendBoxes(boxes);
  }

  std::optional<Interval> intersect(const Ray& ray) const override {
    std::optional<Interval> hull;
    forEachAlong(ray, {0, ray.tMax}, [&](const Volume& v) {
      if (const auto r = v.intersect(ray))
        hull = hull ? Interval{std::min(hull->t0, r->t0), std::max(hull->t1, r->t1)} : *r;
    });
    return hull;
  }

  MediumCoefficients at(const Vec3& p) const override {
    MediumCoefficients sum;
    forEachAt(p, [&](const Volume& v) { sum += v.at(p); });
    return sum;
  }

  Rgb majorant() const override { return majorant_; }

  Rgb opticalDepth(const Ray& ray, Interval range) const override {
    Rgb sum;
    forEachAlong(ray, range, [&](const Volume& v) { sum += v.opticalDepth(ray, range); });
    return sum;
  }

  std::optional<float> invertOpticalDepth(const Ray& ray, Interval range, int channel,
                                          float depth) const override {
    if (depth <= 0) return range.t0;
    const auto t = lookUp(ray, range).invert(channel, double{depth});
    return t ? std::optional(static_cast<float>(*t)) : std::nullopt;
  }

  Rgb emission(const Ray& ray, Interval range) const override {
    return isEmissive() ? lookUp(ray, range).emission() : Rgb();
  }

  Rgb totalEmission() const override { return totalEmission_; }

  Vec3 sampleEmission(Rng& rng) const override {
    // One volume by its share.
    const double x = rng.uniformDouble() * emissionSoFar_.back();
    auto chosen = static_cast<std::size_t>(
        std::upper_bound(emissionSoFar_.begin(), emissionSoFar_.end(), x) - emissionSoFar_.begin());
    // Rounding may lead to the end, or past it.
    chosen = std::min(chosen, volumes_.size() - 1);
    while (chosen > 0 && !volumes_[chosen]->isEmissive()) --chosen;
    return volumes_[chosen]->sampleEmission(rng);
  }

  void appendPieces(const Ray& ray, Interval range,
                    std::vector<MediumPiece>& pieces) const override {
    forEachAlong(ray, range, [&](const Volume& v) { v.appendPieces(ray, range, pieces); });
  }

  bool isClosedForm() const override { return volumes_.size() <= kFew && isClosedForm_; }
  bool isTracked() const override { return isTracked_; }
  bool isEmissive() const override { return isEmissive_; }
  bool isScattering() const override { return isScattering_; }

  Rgb phase(const Vec3& p, const Vec3& wo, const Vec3& wi) const override {
    const Rgb total = at(p).sigma_s;
    if (total.isBlack()) return volumes_.front()->phase(p, wo, wi);
    Rgb sum;
    forEachAt(p, [&](const Volume& v) {
      const Rgb share = shareOf(v.at(p).sigma_s, total);
      if (!share.isBlack()) sum += share * v.phase(p, wo, wi);
    });
    return sum;
  }

  bool appendLobes(const Vec3& p, std::vector<PhaseLobe>& lobes) const override {
    if (!hasLobes_) return false;
    const Rgb total = at(p).sigma_s;
    if (total.isBlack()) {
      lobes.push_back({*volumes_.front()->henyeyGreenstein(), Rgb(1.f)});
      return true;
    }
    forEachAt(p, [&](const Volume& v) {
      const Rgb share = shareOf(v.at(p).sigma_s, total);
      if (!share.isBlack()) lobes.push_back({*v.henyeyGreenstein(), share});
    });
    return true;
  }

  ScatterSample samplePhase(const Vec3& p, const Vec3& wo, const Rgb& carried, float uComponent,
                            Vec2 u) const override {
    const Rgb total = at(p).sigma_s;
    if (total.isBlack()) return volumes_.front()->samplePhase(p, wo, carried, uComponent, u);

    // One volume by its share of what is carried, its own lobe by the rest of the random number.
    float rest = uComponent, offset = 0, chosenWeight = 1;
    const Volume* chosen = nullptr;
    bool isFound = false;
    forEachAt(p, [&](const Volume& v) {
      if (isFound) return;
      const float weight = phasePdf(shareOf(v.at(p).sigma_s, total), carried);
      if (!(weight > 0)) return;
      chosen = &v;
      chosenWeight = weight;
      offset = rest;
      isFound = rest < weight;
      rest -= weight;
    });
    if (!chosen) return {};
    ScatterSample sample = chosen->samplePhase(
        p, wo, carried, std::clamp(offset / chosenWeight, 0.f, kOneMinusEpsilon), u);
    sample.value = phase(p, wo, sample.wi);
    sample.pdf = phasePdf(sample.value, carried);
    return sample;
  }

  float phasePeak() const override { return phasePeak_; }

 private:
  /// So many volumes are asked one after the other; of more, those are that the tree names.
  static constexpr std::size_t kFew = 4;

  /// Volumes that may hold p.
  template <class Visit>
  void forEachAt(const Vec3& p, Visit&& visit) const {
    if (volumes_.size() > kFew)
      tree_.forEachAt(p, [&](std::uint32_t i) { visit(*volumes_[i]); });
    else
      for (const Volume* v : volumes_) visit(*v);
  }
  /// Volumes that the ray may meet.
  template <class Visit>
  void forEachAlong(const Ray& ray, Interval range, Visit&& visit) const {
    if (volumes_.size() > kFew)
      tree_.forEachAlong(ray, range, [&](std::uint32_t i) { visit(*volumes_[i]); });
    else
      for (const Volume* v : volumes_) visit(*v);
  }

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
  BoxTree tree_;  // of more than kFew volumes
  Bounds3 bounds_;
  Rgb majorant_, totalEmission_;
  std::vector<double> emissionSoFar_;  // luminance, of the volumes up to each
  bool isClosedForm_ = true, isTracked_ = false, isEmissive_ = false, isScattering_ = false;
  bool hasLobes_ = true;  // all phase functions are Henyey and Greenstein's
  float phasePeak_ = 0;
};

}  // namespace

std::unique_ptr<Volume> makeAggregateVolume(std::vector<const Volume*> volumes) {
  BRUME_CHECK(!volumes.empty());
  return std::make_unique<Aggregate>(std::move(volumes));
}

}  // namespace brume
