// SPDX-License-Identifier: Apache-2.0
// Measured isotropic BRDFs: the tables and their lobes.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/sampling.h"
#include "materials/lobes.h"

namespace brume {

/// A regular table over (theta_h, theta_d, phi_d), the coordinates of Rusinkiewicz 1998, in the
/// format of the MERL database (Matusik et al. 2003): three little-endian int32 (90, 90, 180), then
/// the red, green and blue table as doubles, phi_d running fastest, theta_h slowest and by its
/// square root. Values are scaled by 1/1500, 1.15/1500 and 1.66/1500; negative ones (no
/// measurement) are 0.
class MerlBrdf {
 public:
  static constexpr int kThetaH = 90, kThetaD = 90, kPhiD = 180;

  /// Throws SceneError at `where` for a file that cannot be read, is of another size or holds
  /// anything but finite numbers.
  MerlBrdf(const std::string& path, const SourceLocation& where);
  /// Whether the file's first bytes and its size are those of a table.
  static bool hasUsualHead(const std::string& path);
  /// Memory that the table of a file takes, about.
  static double bytesOf(const std::string& path);

  /// [1/sr], the nearest entry.
  Rgb f(const Vec3& wo, const Vec3& wi) const;
  /// Facet normals with z >= 0, distributed about as the table's mean over theta_d and phi_d.
  Vec3 sampleHalfVector(Vec2 u) const;
  float pdfHalfVector(const Vec3& wh) const;

 private:
  static int thetaHIndex(float theta);
  void tabulateHalfVectors();

  std::vector<Rgb> table_;
  Distribution1D thetaH_;                         // probability of each row
  std::array<float, kThetaH + 1> oneMinusCos_{};  // of the rows' borders
  std::array<float, kThetaH> pdfOfRow_{};         // per solid angle of wh
};

/// Irregular samples at points m = (sin_i sin_o, |dphi| / pi, cos_i cos_o), interpolated with
/// weights exp(-100 |m - m_k|^2) within the smallest radius, r^2 = 0.001 * 2^n, that holds more
/// than two (PBRT-v2's scheme). Text: the number of wavelengths, the wavelengths [nm], then per
/// sample theta_i phi_i theta_o phi_o [rad] and one value per wavelength; # starts a comment.
class IrregularBrdf {
 public:
  /// Throws SceneError as MerlBrdf.
  IrregularBrdf(const std::string& path, const SourceLocation& where);
  /// Whether it is a long text that begins with numbers as they should be. One of up to 64 KiB is
  /// read as quickly as looked at.
  static bool hasUsualHead(const std::string& path);
  /// Memory that the samples of a file take, about.
  static double bytesOf(const std::string& path);

  Rgb f(const Vec3& wo, const Vec3& wi) const;

 private:
  struct Sample {
    Vec3 m;
    Rgb value;
  };
  static Vec3 remap(const Vec3& wo, const Vec3& wi);
  void sortIntoGrid(const std::vector<Sample>& samples);
  int cellOf(float m, int axis) const;

  Vec3 lo_{0}, cellsPerUnit_{0};
  int resolution_ = 1;                // cells along each axis
  std::vector<std::uint32_t> first_;  // of each cell in samples_, x fastest; one more at the end
  std::vector<Sample> samples_;
};

/// Half of the samples follow the cosine, half the table's half vectors.
class MerlLobe final : public Lobe {
 public:
  explicit MerlLobe(const MerlBrdf& brdf) : Lobe(kReflection | kGlossy), brdf_(&brdf) {}
  Rgb f(const Vec3& wo, const Vec3& wi) const override { return brdf_->f(wo, wi); }
  float pdf(const Vec3& wo, const Vec3& wi) const override;
  std::optional<BsdfSample> sample(const Vec3& wo, Vec2 u) const override;

 private:
  const MerlBrdf* brdf_;
};

class IrregularLobe final : public Lobe {
 public:
  explicit IrregularLobe(const IrregularBrdf& brdf) : Lobe(kReflection | kGlossy), brdf_(&brdf) {}
  Rgb f(const Vec3& wo, const Vec3& wi) const override { return brdf_->f(wo, wi); }

 private:
  const IrregularBrdf* brdf_;
};

}  // namespace brume
