// SPDX-License-Identifier: Apache-2.0
// LDR-FLIP: Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild 2020, "FLIP: A
// Difference Evaluator for Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2).
// Section numbers below are those of the paper.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/srgb.h"
#include "tools/image_metrics.h"

namespace brume {
namespace {

constexpr float kColorExponent = 0.7f;    // q_c
constexpr float kFeatureExponent = 0.5f;  // q_f
constexpr float kKnee = 0.4f;             // p_c: share of the largest colour error ...
constexpr float kKneeValue = 0.95f;       // p_t: ... that is mapped to this
constexpr double kFeatureWidth = 0.082;   // w: feature detectors, degrees from peak to trough

constexpr double kPi2 = std::numbers::pi * std::numbers::pi;

/// Linear Rec. 709 to CIE XYZ relative to the white (1, 1, 1), so that white is (1, 1, 1).
Rgb toRelativeXyz(const Rgb& c) {
  const auto row = [&](double r, double g, double b) {
    return static_cast<float>((r * c.r + g * c.g + b * c.b) / (r + g + b));
  };
  return {row(10135552. / 24577794, 8788810. / 24577794, 4435075. / 24577794),
          row(2613072. / 12288897, 8788810. / 12288897, 887015. / 12288897),
          row(1425312. / 73733382, 8788810. / 73733382, 70074185. / 73733382)};
}

/// The inverse of toRelativeXyz.
Rgb fromRelativeXyz(const Rgb& c) {
  // White of the matrix above.
  constexpr double kX = (10135552. + 8788810. + 4435075.) / 24577794;
  constexpr double kZ = (1425312. + 8788810. + 70074185.) / 73733382;
  const double x = c.r * kX, y = c.g, z = c.b * kZ;
  const auto row = [&](double a, double b, double d) {
    return static_cast<float>(a * x + b * y + d * z);
  };
  return {row(3.241003233, -1.537398969, -0.498615882), row(-0.969224252, 1.875929984, 0.041554226),
          row(0.055639420, -0.204011206, 1.057148977)};
}

/// Opponent space Y Cx Cz, linear in light (section 4.1.1).
Rgb toOpponent(const Rgb& linear) {
  const Rgb xyz = toRelativeXyz(linear);
  return {116 * xyz.g - 16, 500 * (xyz.r - xyz.g), 200 * (xyz.g - xyz.b)};
}
Rgb fromOpponent(const Rgb& c) {
  const float y = (c.r + 16) / 116;
  return fromRelativeXyz({y + c.g / 500, y, y - c.b / 200});
}

/// CIELAB with the Hunt effect: chroma scaled by lightness (section 4.1.2).
Rgb toHuntLab(const Rgb& linear) {
  const auto f = [](float t) {
    constexpr float kDelta = 6.f / 29;
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.f / 29;
  };
  const Rgb xyz = toRelativeXyz(linear);
  const float fx = f(xyz.r), fy = f(xyz.g), fz = f(xyz.b);
  const float lightness = 116 * fy - 16;
  return {lightness, 0.01f * lightness * 500 * (fx - fy), 0.01f * lightness * 200 * (fy - fz)};
}

/// HyAB distance: city block between lightness and chroma, Euclidean within chroma (4.1.3).
float hyab(const Rgb& a, const Rgb& b) {
  return std::abs(a.r - b.r) + std::hypot(a.g - b.g, a.b - b.b);
}

/// Colour errors to [0, 1]: the lower 40 % of the possible range take 95 % of it (4.1.4).
float redistribute(float error, float largest) {
  const float knee = kKnee * largest;
  if (error < knee) return kKneeValue / knee * error;
  return kKneeValue + (error - knee) / (largest - knee) * (1 - kKneeValue);
}

/// A 1-D filter of 2 radius + 1 weights.
using Kernel = std::vector<double>;
int radiusOf(const Kernel& k) { return static_cast<int>(k.size() / 2); }

template <class F>
Kernel makeKernel(int radius, const F& weight) {
  Kernel kernel;
  for (int i = -radius; i <= radius; ++i) kernel.push_back(weight(i));
  return kernel;
}

double sumOf(const Kernel& k) {
  double sum = 0;
  for (const double w : k) sum += w;
  return sum;
}

/// Correlation with kx along x and ky along y; the border pixels are repeated outwards.
ScalarImage filtered(const ScalarImage& image, const Kernel& kx, const Kernel& ky) {
  const int w = image.width, h = image.height;
  ScalarImage rows(w, h), result(w, h);
  const int rx = radiusOf(kx), ry = radiusOf(ky);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      double sum = 0;
      for (int i = -rx; i <= rx; ++i)
        sum += kx[static_cast<std::size_t>(i + rx)] * image.at(std::clamp(x + i, 0, w - 1), y);
      rows.at(x, y) = static_cast<float>(sum);
    }
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      double sum = 0;
      for (int i = -ry; i <= ry; ++i)
        sum += ky[static_cast<std::size_t>(i + ry)] * rows.at(x, std::clamp(y + i, 0, h - 1));
      result.at(x, y) = static_cast<float>(sum);
    }
  return result;
}

/// Contrast sensitivity of one opponent channel: a1 sqrt(pi/b1) exp(-pi^2 r^2 / b1) + the same with
/// a2, b2; r in degrees (table 1).
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr Sensitivity kAchromatic{1, 0.0047, 0, 1e-5};
constexpr Sensitivity kRedGreen{1, 0.0053, 0, 1e-5};
constexpr Sensitivity kBlueYellow{34.1, 0.04, 13.5, 0.025};
constexpr double kWidestB = 0.04;

/// One channel blurred by what the eye cannot resolve: a sum of two separable Gaussians over a
/// common window, normalised together.
ScalarImage blurred(const ScalarImage& channel, const Sensitivity& s, double pixelsPerDegree) {
  const int radius =
      static_cast<int>(std::ceil(3 * std::sqrt(kWidestB / (2 * kPi2)) * pixelsPerDegree));
  const auto gaussian = [&](double b) {
    return makeKernel(radius,
                      [&](int i) { return std::exp(-kPi2 * sqr(i / pixelsPerDegree) / b); });
  };
  const Kernel k1 = gaussian(s.b1), k2 = gaussian(s.b2);
  const double w1 = s.a1 * std::sqrt(std::numbers::pi / s.b1);
  const double w2 = s.a2 * std::sqrt(std::numbers::pi / s.b2);
  const double total = w1 * sqr(sumOf(k1)) + w2 * sqr(sumOf(k2));
  ScalarImage result = filtered(channel, k1, k1);
  for (float& v : result.values) v = static_cast<float>(v * w1 / total);
  if (w2 > 0) {
    const ScalarImage second = filtered(channel, k2, k2);
    for (std::size_t i = 0; i < result.values.size(); ++i)
      result.values[i] += static_cast<float>(second.values[i] * w2 / total);
  }
  return result;
}

/// Positive weights scaled to sum 1, negative ones to -1.
Kernel balanced(Kernel kernel) {
  double positive = 0, negative = 0;
  for (const double w : kernel) (w > 0 ? positive : negative) += std::abs(w);
  for (double& w : kernel) w /= w > 0 ? positive : negative;
  return kernel;
}

/// Gradient magnitudes of edges (first derivative of a Gaussian) or points (second) (4.2).
ScalarImage features(const ScalarImage& luminance, double pixelsPerDegree, bool points) {
  const double sigma = 0.5 * kFeatureWidth * pixelsPerDegree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  const auto gauss = [&](int i) { return std::exp(-sqr(i / sigma) / 2); };
  Kernel across = makeKernel(radius, gauss);
  const double sum = sumOf(across);
  for (double& w : across) w /= sum;
  const Kernel along = balanced(
      makeKernel(radius, [&](int i) { return (points ? sqr(i / sigma) - 1 : -i) * gauss(i); }));
  ScalarImage x = filtered(luminance, along, across);
  const ScalarImage y = filtered(luminance, across, along);
  for (std::size_t i = 0; i < x.values.size(); ++i)
    x.values[i] = std::hypot(x.values[i], y.values[i]);
  return x;
}

/// One image on its way through the metric.
struct Seen {
  std::vector<Rgb> lab;  ///< blurred, in Hunt-adjusted CIELAB
  ScalarImage edges, points;
};

Seen look(const RgbImage& image, double pixelsPerDegree) {
  ScalarImage channels[3];
  for (ScalarImage& c : channels) c = ScalarImage(image.width, image.height);
  ScalarImage luminance(image.width, image.height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    Rgb displayed;
    for (int c = 0; c < 3; ++c) {
      const float v = image.pixels[i][c];
      displayed[c] = v > 0 ? std::min(v, 1.f) : 0.f;  // NaN too becomes 0
    }
    const Rgb opponent = toOpponent(displayed);
    for (int c = 0; c < 3; ++c) channels[c].values[i] = opponent[c];
    luminance.values[i] = (opponent.r + 16) / 116;
  }
  Seen seen;
  const ScalarImage y = blurred(channels[0], kAchromatic, pixelsPerDegree);
  const ScalarImage cx = blurred(channels[1], kRedGreen, pixelsPerDegree);
  const ScalarImage cz = blurred(channels[2], kBlueYellow, pixelsPerDegree);
  seen.lab.reserve(image.pixels.size());
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const Rgb linear = fromOpponent({y.values[i], cx.values[i], cz.values[i]});
    seen.lab.push_back(toHuntLab(min(max(linear, 0.f), 1.f)));
  }
  seen.edges = features(luminance, pixelsPerDegree, false);
  seen.points = features(luminance, pixelsPerDegree, true);
  return seen;
}

}  // namespace

FlipResult flip(const RgbImage& a, const RgbImage& b, double pixelsPerDegree) {
  if (a.width != b.width || a.height != b.height) throw SceneError("the images differ in size");
  // Below the filters vanish between the pixels; above they outgrow the image.
  if (!(pixelsPerDegree >= 1 && pixelsPerDegree <= 1000))
    throw SceneError("FLIP needs between 1 and 1000 pixels per degree");
  const Seen seenA = look(a, pixelsPerDegree), seenB = look(b, pixelsPerDegree);
  // The largest colour error is between pure green and pure blue.
  const float largest = std::pow(hyab(toHuntLab({0, 1, 0}), toHuntLab({0, 0, 1})), kColorExponent);

  FlipResult result{ScalarImage(a.width, a.height), 0};
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const float color =
        redistribute(std::pow(hyab(seenA.lab[i], seenB.lab[i]), kColorExponent), largest);
    const float difference = std::max(std::abs(seenA.edges.values[i] - seenB.edges.values[i]),
                                      std::abs(seenA.points.values[i] - seenB.points.values[i]));
    const float feature = std::pow(difference / std::numbers::sqrt2_v<float>, kFeatureExponent);
    const float error = std::clamp(std::pow(color, 1 - std::min(feature, 1.f)), 0.f, 1.f);
    result.map.values[i] = error;
    sum += error;
  }
  if (!a.pixels.empty()) result.mean = sum / static_cast<double>(a.pixels.size());
  return result;
}

}  // namespace brume
