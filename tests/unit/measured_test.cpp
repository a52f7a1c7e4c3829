// SPDX-License-Identifier: Apache-2.0
// Measured BRDFs on files made here, both formats.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <cstring>

#include <filesystem>
#include <fstream>

#include "core/deferred.h"
#include "core/file_cache.h"
#include "core/rng.h"
#include "core/spectrum.h"
#include "support/bsdf_checks.h"

namespace brume::test {
namespace {

using testing::HasSubstr;

/// Of this process alone: tests of one suite run side by side.
std::string tempPath(const std::string& name) {
  return testing::TempDir() + "brume_" + std::to_string(::getpid()) + "_" + name;
}

void write(const std::string& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::unique_ptr<Material> load(const std::string& path, FileCache* files = nullptr) {
  Material::FactoryContext context;
  context.files = files;
  return make<Material>("measured", {string("filename", path)}, context);
}

/// A point whose frame is the axes: no rounding between render and local space.
SurfaceInteraction axesPoint() {
  SurfaceInteraction at;
  at.shading.dpdu = {1, 0, 0};
  at.shading.dpdv = {0, 1, 0};
  return at;
}

/// What is said when the material is made.
std::string errorOf(const std::string& path, FileCache* files = nullptr) {
  try {
    load(path, files);
  } catch (const SceneError& e) {
    return e.what();
  }
  return "no error";
}
/// What is said when a material that could be made is looked up.
std::string lateErrorOf(const std::string& path) {
  const std::unique_ptr<Material> material = load(path);
  Bsdf bsdf;
  try {
    material->evaluate(axesPoint(), bsdf);
  } catch (const SceneError& e) {
    return e.what();
  }
  return "no error";
}

// --- MERL ----------------------------------------------------------------------------------------

constexpr int kH = 90, kD = 90, kP = 180;
constexpr std::size_t kEntries = std::size_t{kH} * kD * kP;
constexpr double kRedPeak = 5000, kGreenUnit = 1e-6;

/// Red is a glossy lobe over theta_h, green numbers the entries, blue was not measured.
std::string merlBytes() {
  std::vector<double> values(3 * kEntries);
  for (int h = 0; h < kH; ++h) {
    const double theta = sqr((h + .5) / kH) * 1.5707963267948966;
    const double lobe = kRedPeak * std::pow(std::cos(theta), 200);
    for (int i = 0; i < kD * kP; ++i) {
      const std::size_t entry = static_cast<std::size_t>(h) * kD * kP + i;
      values[entry] = lobe;
      values[kEntries + entry] = kGreenUnit * static_cast<double>(entry);
      values[2 * kEntries + entry] = -1;
    }
  }
  const std::int32_t dims[3] = {kH, kD, kP};
  std::string bytes(sizeof dims + values.size() * sizeof(double), '\0');
  std::memcpy(bytes.data(), dims, sizeof dims);
  std::memcpy(bytes.data() + sizeof dims, values.data(), values.size() * sizeof(double));
  return bytes;
}

class MerlTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    bytes_ = new std::string(merlBytes());
    write(tempPath("lobe.binary"), *bytes_);
    material_ = load(tempPath("lobe.binary")).release();
  }
  static void TearDownTestSuite() {
    delete material_;
    delete bytes_;
    std::filesystem::remove(tempPath("lobe.binary"));
  }
  static std::string errorWith(const std::string& bytes) {
    const std::string path = tempPath("bad.merl");
    write(path, bytes);
    const std::string text = errorOf(path);
    std::filesystem::remove(path);
    return text;
  }
  static inline const std::string* bytes_ = nullptr;
  static inline Material* material_ = nullptr;
};

TEST_F(MerlTest, LooksUpHalfAndDifferenceAngles) {
  Bsdf bsdf;
  material_->evaluate(axesPoint(), bsdf);
  for (const int h : {0, 1, 30, 60})
    for (const int d : {0, 20, 40})
      for (const int p : {0, 50, 100, 179})
        for (const float azimuth : {.2f, 4.f}) {
          // The directions at the middle of an entry, for a half vector of any azimuth.
          const double thetaH = sqr((h + .5) / kH) * 1.5707963267948966;
          const double thetaD = (d + .5) / kD * 1.5707963267948966;
          const double phiD = (p + .5) / kP * 3.14159265358979;
          const Vec3d wd{std::sin(thetaD) * std::cos(phiD), std::sin(thetaD) * std::sin(phiD),
                         std::cos(thetaD)};
          const Vec3d tilted{std::cos(thetaH) * wd.x + std::sin(thetaH) * wd.z, wd.y,
                             -std::sin(thetaH) * wd.x + std::cos(thetaH) * wd.z};
          const double c = std::cos(azimuth), s = std::sin(azimuth);
          const Vec3 wi(Vec3d(c * tilted.x - s * tilted.y, s * tilted.x + c * tilted.y, tilted.z));
          const Vec3d wh{std::sin(thetaH) * c, std::sin(thetaH) * s, std::cos(thetaH)};
          const Vec3 wo(2 * dot(wh, Vec3d(wi)) * wh - Vec3d(wi));
          if (wi.z <= 0 || wo.z <= 0) continue;
          // The first row is 1.9e-4 rad wide: float half vectors lie in it, but not their azimuth.
          if (h == 0) continue;
          const Rgb f = bsdf.f(wo, wi);
          const double entry = f.g / (1.15 / 1500) / kGreenUnit;
          EXPECT_NEAR(entry, (h * kD + d) * kP + p, .3) << h << " " << d << " " << p;
          EXPECT_NEAR(f.r, kRedPeak / 1500 * std::pow(std::cos(thetaH), 200), 1e-5);
          EXPECT_EQ(f.b, 0);
          EXPECT_NEAR(bsdf.f(wi, wo).g, f.g, 1e-6f * f.g);  // reciprocal
        }
}

TEST_F(MerlTest, SamplingFollowsItsPdfAndTheTable) {
  Bsdf bsdf;
  material_->evaluate(planePoint(), bsdf);
  for (const float cosine : {.95f, .5f, -.3f}) {
    const Vec3 wo = fromPlane(localDirection(cosine, 1));
    EXPECT_GT(chiSquareOfSampling(bsdf, wo, 40000), 1e-4);
    const Estimate e = estimateAlbedo(bsdf, wo, kAllLobes, 10000);
    const Rgb exact = integrateF(bsdf, wo, 128);
    EXPECT_NEAR(e.mean[0], exact.r, 5 * e.error[0] + 5e-3 * exact.r);
    // Cosine sampling alone has an error of 5 % here (lobe of 0.1 rad, 10000 samples).
    EXPECT_LT(e.error[0], .015 * e.mean[0]);
  }
}

TEST_F(MerlTest, SharesTheTableOfAFile) {
  const std::string path = tempPath("shared.merl");
  write(path, *bytes_);
  FileCache files;
  const std::unique_ptr<Material> first = load(path, &files), second = load(path, &files);
  EXPECT_EQ(DeferredFiles::of(files).count().unread, 1u);
  Bsdf bsdf;
  first->evaluate(axesPoint(), bsdf);
  EXPECT_EQ(DeferredFiles::of(files).count().read, 1u);
  std::filesystem::remove(path);
  EXPECT_NO_THROW(second->evaluate(axesPoint(), bsdf)) << "the file is not read again";
  EXPECT_EQ(errorOf(path, &files), "no error");
  EXPECT_THAT(errorOf(path), HasSubstr("no such file"));
}

TEST_F(MerlTest, RefusesWhatIsNoMerlFile) {
  std::string longer = *bytes_ + "x", shorter = bytes_->substr(0, 1000);
  EXPECT_THAT(errorWith(shorter), HasSubstr("is cut short: 1000 bytes instead of 34992012"));
  EXPECT_THAT(errorWith(longer), HasSubstr("is too long"));
  EXPECT_THAT(errorWith(""), HasSubstr("is not a measured BRDF in the MERL format"));
  EXPECT_THAT(errorWith(std::string(100, 'x')), HasSubstr("must start with the 32-bit integers"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::string broken = *bytes_;
  std::memcpy(broken.data() + 12 + 8 * 5, &nan, sizeof nan);
  // The head is right, so this shows when a ray meets the material.
  const std::string path = tempPath("broken.merl");
  write(path, broken);
  EXPECT_THAT(lateErrorOf(path), HasSubstr("holds the value nan at byte 52"));
  std::filesystem::remove(path);
  EXPECT_THAT(errorOf(tempPath("absent.binary")), HasSubstr("no such file"));
  EXPECT_THROW(make<Material>("measured", {}), SceneError);
}

// --- irregular samples ---------------------------------------------------------------------------

struct TextSample {
  float thetaI, phiI, thetaO, phiO;
  float values[3];
};

std::string brdfText(const std::vector<TextSample>& samples) {
  std::string text = "# wavelengths\n3\n450 550 650 # nm\n";
  for (const TextSample& s : samples) {
    for (const float v :
         {s.thetaI, s.phiI, s.thetaO, s.phiO, s.values[0], s.values[1], s.values[2]})
      text += std::to_string(v) + " ";
    text += "\n";
  }
  return text;
}

float roundAsText(float v) { return std::stof(std::to_string(v)); }

std::vector<TextSample> randomSamples(int n, float maxTheta) {
  Rng rng(5);
  std::vector<TextSample> samples(static_cast<std::size_t>(n));
  for (TextSample& s : samples) {
    for (float* v : {&s.thetaI, &s.thetaO}) *v = roundAsText(maxTheta * rng.uniform());
    for (float* v : {&s.phiI, &s.phiO}) *v = roundAsText(6.28f * rng.uniform());
    for (float& v : s.values) v = roundAsText(rng.uniform() - .1f);
  }
  return samples;
}

std::unique_ptr<Material> loadText(const std::string& name, const std::string& text) {
  write(tempPath(name), text);
  std::unique_ptr<Material> material = load(tempPath(name));
  Bsdf bsdf;
  material->evaluate(axesPoint(), bsdf);  // a long text is read now
  std::filesystem::remove(tempPath(name));
  return material;
}

Vec3 remap(const Vec3& wo, const Vec3& wi) {
  const auto azimuth = [](const Vec3& w) {
    const float phi = std::atan2(w.y, w.x);
    return phi < 0 ? phi + 2 * kPi : phi;
  };
  float dphi = std::abs(azimuth(wi) - azimuth(wo));
  dphi = std::min(dphi, 2 * kPi - dphi);
  return {sinTheta(wi) * sinTheta(wo), dphi / kPi, wi.z * wo.z};
}

/// The interpolation by a plain loop over all samples.
Rgb plainLookup(const std::vector<TextSample>& samples, const Vec3& wo, const Vec3& wi) {
  const float wavelengths[3] = {450, 550, 650};
  const Vec3 m = remap(wo, wi);
  for (double radius2 = .001;; radius2 *= 2) {
    double sum[3] = {0, 0, 0}, weights = 0;
    int found = 0;
    for (const TextSample& s : samples) {
      const auto direction = [](float theta, float phi) {
        return Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                    std::cos(theta));
      };
      const Vec3 k = remap(direction(s.thetaO, s.phiO), direction(s.thetaI, s.phiI));
      const double d2 = lengthSquared(k - m);
      if (d2 >= radius2 && radius2 <= 1.5) continue;
      const Rgb color = rgbFromSamples(wavelengths, s.values);
      const double weight = std::exp(-100 * d2);
      for (int c = 0; c < 3; ++c) sum[c] += weight * color[c];
      weights += weight;
      ++found;
    }
    if (found < 3 && radius2 <= 1.5) continue;
    Rgb result;
    for (int c = 0; c < 3; ++c) result[c] = static_cast<float>(std::max(0.0, sum[c] / weights));
    return result;
  }
}

TEST(IrregularBrdf, EqualsThePlainLoopOverAllSamples) {
  // Dense, sparse, and clustered near the normal, so that the search has to widen.
  for (const auto& [n, maxTheta] : {std::pair{800, 1.57f}, {20, 1.57f}, {50, .2f}, {2, 1.f}}) {
    const std::vector<TextSample> samples = randomSamples(n, maxTheta);
    const auto material = loadText("random.brdf", brdfText(samples));
    Bsdf bsdf;
    material->evaluate(axesPoint(), bsdf);
    Rng rng(6);
    for (int i = 0; i < 100; ++i) {
      const float co = rng.uniform(), ci = rng.uniform();
      const Vec3 wo = localDirection(co, 6 * rng.uniform());
      const Vec3 wi = localDirection(ci, 6 * rng.uniform());
      const Rgb f = bsdf.f(wo, wi), expected = plainLookup(samples, wo, wi);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(f[c], expected[c], 1e-5 + 1e-4 * expected[c]);
    }
  }
}

TEST(IrregularBrdf, OfEqualSamplesIsConstant) {
  std::vector<TextSample> samples = randomSamples(300, 1.5f);
  for (TextSample& s : samples) s.values[0] = s.values[1] = s.values[2] = .25f;
  const auto material = loadText("constant.brdf", brdfText(samples));
  Bsdf bsdf;
  material->evaluate(planePoint(), bsdf);
  const float wavelengths[] = {500};
  const float values[] = {.25f};
  const Rgb expected = rgbFromSamples(wavelengths, values);
  for (const float cosine : {1.f, .3f, -.2f, -1.f}) {
    const Vec3 wo = fromPlane(localDirection(cosine, 1));
    const Rgb albedo = bsdf.reflectance(wo, kAllLobes);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(albedo[c], expected[c] * kPi, 1e-4);
    EXPECT_GT(chiSquareOfSampling(bsdf, wo, 20000), 1e-4);
  }
}

TEST(IrregularBrdf, LongTextsAreReadAtTheFirstLookup) {
  const std::string path = tempPath("long.brdf"), text = brdfText(randomSamples(3000, 1.5f));
  ASSERT_GT(text.size(), std::size_t{1} << 17);
  write(path, text);
  EXPECT_EQ(lateErrorOf(path), "no error");
  write(path, text + " .5");
  EXPECT_THAT(lateErrorOf(path), HasSubstr("is cut short or has numbers to spare"));
  // What is wrong at the beginning shows at once.
  write(path, "0 " + text);
  EXPECT_THAT(errorOf(path), HasSubstr("the number of wavelengths must be an integer"));
  write(path, "x" + text);
  EXPECT_THAT(errorOf(path), HasSubstr("other than a number in line 1"));
  std::filesystem::remove(path);
}

TEST(IrregularBrdf, RefusesBrokenFiles) {
  const auto errorWith = [](const std::string& text) {
    write(tempPath("broken.brdf"), text);
    const std::string error = errorOf(tempPath("broken.brdf"));
    std::filesystem::remove(tempPath("broken.brdf"));
    return error;
  };
  EXPECT_THAT(errorWith(""), HasSubstr("is empty"));
  EXPECT_THAT(errorWith("# nothing\n"), HasSubstr("is empty"));
  EXPECT_THAT(errorWith("1 500"), HasSubstr("has no sample"));
  EXPECT_THAT(errorWith("1 500 .1 .2 .3 .4"), HasSubstr("has no sample"));
  EXPECT_THAT(errorWith("1 500 .1 .2 .3 .4 .5 .6"),
              HasSubstr("after 1 wavelengths, 6 numbers are not a multiple of 5"));
  for (const char* count : {"0", "-3", "1.5", "2000", "1e30"})
    EXPECT_THAT(errorWith(std::string(count) + " 500 1 1 1 1 1"),
                HasSubstr("the number of wavelengths must be an integer from 1 to 1000"));
  EXPECT_THAT(errorWith("1 500\n.1 .2 .3 .4 x\n"), HasSubstr("other than a number in line 2"));
  EXPECT_THAT(errorWith("1 500 .1 .2 .3 .4 nan"), HasSubstr("other than a number in line 1"));
  EXPECT_THAT(errorWith(std::string(1000, '\xff')), HasSubstr("other than a number"));
  EXPECT_EQ(errorWith("1 500 .1 .2 .3 .4 +.5"), "no error");
  EXPECT_THAT(errorOf(tempPath("absent.brdf")), HasSubstr("no such file"));
}

}  // namespace
}  // namespace brume::test
