// SPDX-License-Identifier: Apache-2.0
#include "tools/regress.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/error.h"
#include "tools/regress_judge.h"
#include "tools/regress_page.h"
#include "tools/regress_rules.h"
#include "tools/render_frame.h"

namespace brume {
namespace {

/// Image and reference are drawn from different random numbers.
constexpr std::uint64_t kImageSeed = 0, kReferenceSeed = 1;

/// Ends the loop over the scenes after a signal.
struct Interrupted {};

/// Below the line of its scene.
std::string indented(const std::string& text) {
  std::string result = "        ";
  for (const char c : text) {
    result += c;
    if (c == '\n') result += "        ";
  }
  return result;
}

class Regression {
 public:
  Regression(const RegressOptions& options, Log& log, const std::atomic<bool>& stop)
      : options_(options), log_(log), stop_(stop), gallery_(options.output) {}

  RegressOutcome run(const std::function<void(const std::string&)>& say);

 private:
  RenderResult render(const RegressScene& scene, const std::vector<std::string>& integrators,
                      int passes, std::uint64_t seed);
  void update(const RegressScene& scene, RegressResult& result);
  void compare(const RegressScene& scene, RegressResult& result);

  const RegressOptions& options_;
  Log& log_;
  const std::atomic<bool>& stop_;
  RegressGallery gallery_;
};

RenderResult Regression::render(const RegressScene& scene,
                                const std::vector<std::string>& integrators, int passes,
                                std::uint64_t seed) {
  RenderSettings settings;
  settings.seed = seed;
  settings.passes = passes;
  settings.integrators = integrators;
  settings.variance = true;
  RenderResult result = renderFrame(scene.file, settings, log_, stop_);
  if (result.reason == StopReason::Interrupted) throw Interrupted{};
  return result;
}

void Regression::update(const RegressScene& scene, RegressResult& result) {
  const RegressRules& rules = scene.rules;
  const auto& integrators =
      rules.referenceIntegrators.empty() ? rules.integrators : rules.referenceIntegrators;
  const RenderResult reference = render(scene, integrators, rules.referencePasses, kReferenceSeed);
  writeImage(scene.reference, reference.image);
  result.figures = fmt::format("wrote {}", scene.reference);
  result.seconds = reference.seconds;
}

void Regression::compare(const RegressScene& scene, RegressResult& result) {
  if (!std::filesystem::exists(scene.reference))
    throw SceneError(fmt::format("there is no reference '{}'; --update makes it", scene.reference));
  const LayeredImage reference = readLayeredImage(scene.reference);
  const RenderResult image = render(scene, scene.rules.integrators, scene.rules.passes, kImageSeed);
  result.seconds = image.seconds;
  const RegressVerdict verdict = judge(image.image, reference, scene.rules);
  result.figures = verdict.figures;
  result.failures = verdict.failures;
  for (const Stat fault : {Stat::NanRadiance, Stat::InfiniteRadiance, Stat::NegativeRadiance})
    if (image.stats[fault] > 0)
      result.failures.push_back(fmt::format("{}: {}", statName(fault), image.stats[fault]));
  if (!result.passed()) gallery_.add(result, image.image, reference, verdict);
}

RegressOutcome Regression::run(const std::function<void(const std::string&)>& say) {
  RegressOutcome outcome;
  for (const RegressScene& scene : findRegressScenes(options_)) {
    RegressResult result;
    result.name = scene.name;
    try {
      if (options_.update)
        update(scene, result);
      else
        compare(scene, result);
    } catch (const Interrupted&) {
      outcome.isInterrupted = true;
      break;
    } catch (const SceneError& error) {
      result.failures = {formatDiagnostic(error.where(), "error", error.what())};
      gallery_.add(result);
    }
    say(fmt::format("{} {:<28} {:6.2f} s  {}",
                    !result.passed()  ? "FAILED "
                    : options_.update ? "updated"
                                      : "passed ",
                    result.name, result.seconds, result.figures));
    for (const std::string& failure : result.failures) say(indented(failure));
    outcome.results.push_back(std::move(result));
  }
  gallery_.finish(outcome.results.size());
  return outcome;
}

}  // namespace

bool RegressOutcome::passed() const {
  return !isInterrupted && std::all_of(results.begin(), results.end(),
                                       [](const RegressResult& r) { return r.passed(); });
}

RegressOutcome regress(const RegressOptions& options, Log& log, const std::atomic<bool>& stop,
                       const std::function<void(const std::string&)>& say) {
  return Regression(options, log, stop).run(say);
}

}  // namespace brume
