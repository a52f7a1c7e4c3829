// SPDX-License-Identifier: Apache-2.0
#include "main/render_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <set>

#include "core/io/image.h"
#include "core/parallel.h"
#include "core/parse/scene_description.h"
#include "main/failure.h"
#include "main/process_memory.h"
#include "main/progress.h"
#include "main/signals.h"
#include "tools/json_report.h"
#include "tools/text_file.h"

namespace brume {
namespace {

/// Ends the parsing of a scene whose frame was interrupted; caught by RenderRun::run alone.
struct Interrupted {};

class Stopwatch {
 public:
  /// Seconds since the last call, or since the watch was made.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// A progressive render leaves its first image after this time, the next ones at growing intervals.
constexpr double kSecondsToFirstImage = 2;

/// One call of brume: the scenes of a RenderCommand and what became of them.
class RenderRun {
 public:
  explicit RenderRun(const RenderCommand& command) : command_(command), log_(command.log) {}

  int run();

 private:
  void doScene(const std::string& scene);
  void doFrame(SceneDescription description, FrameReport report);
  void render(RenderJob& job, FrameReport report);
  void checkOutput(const std::string& image);
  void noteOutput(const std::string& file);
  void writeOutput(const std::string& image, const RenderResult& result, PixelPrecision precision);
  void rescueImage(const Film::Settings& film, const RenderResult& soFar);
  void warnAboutFaults(const Stats& stats);
  void warnOfHalves(const std::string& name, const LayeredImage& image);
  void say(const std::string& line) const {
    if (command_.log.verbosity != Verbosity::Quiet) std::fprintf(stderr, "%s\n", line.c_str());
  }

  const RenderCommand& command_;
  Log log_;
  std::vector<FrameReport> reports_;
  std::set<std::string> written_;
};

int RenderRun::run() {
  setThreadCount(command_.threads);
  if (!command_.statsFile.empty()) checkTextFileWritable(command_.statsFile);
  int exitCode = kExitDone;
  for (const std::string& scene : command_.scenes) {
    try {
      doScene(scene);
    } catch (const Interrupted&) {
      return 128 + StopOnSignal::received();
    } catch (...) {
      exitCode = std::max(exitCode, reportFailure());
    }
  }
  return exitCode;
}

void RenderRun::doScene(const std::string& scene) {
  Stopwatch watch;
  int frame = 0;
  parseSceneFile(scene, ParseSettings{command_.settings.quick}, log_, [&](SceneDescription d) {
    FrameReport report;
    report.scene = scene;
    report.frame = ++frame;
    report.seconds.parse = watch.lap();
    doFrame(std::move(d), std::move(report));
    watch.lap();
  });
  if (frame == 0)
    throw SceneError(
        fmt::format("'{}' holds no WorldBegin ... WorldEnd: there is nothing to render", scene));
  if (command_.action == RenderCommand::Action::Check) say(fmt::format("{}: valid", scene));
}

void RenderRun::doFrame(SceneDescription description, FrameReport report) {
  Stopwatch watch;
  RenderJob job(std::move(description), command_.settings, log_);
  report.seconds.build = watch.lap();
  switch (command_.action) {
    case RenderCommand::Action::Check:
      job.readAllFiles(written_);
      for (const std::string& file : job.outputs()) noteOutput(file);
      return;
    case RenderCommand::Action::Plan:
      for (const std::string& line : job.plan()) std::printf("%s\n", line.c_str());
      return;
    case RenderCommand::Action::Render:
      return render(job, std::move(report));
  }
}

void RenderRun::checkOutput(const std::string& image) {
  if (!isWritableImageName(image))
    throw SceneError(
        fmt::format("cannot write '{}': the name of an image ends in .exr, .png, .pfm "
                    "or .tga",
                    image));
  checkWritable(image);
  noteOutput(image);
}

void RenderRun::noteOutput(const std::string& file) {
  if (!written_.insert(file).second)
    log_.warning({}, fmt::format("this frame replaces '{}', which an earlier frame wrote", file));
}

void RenderRun::writeOutput(const std::string& image, const RenderResult& result,
                            PixelPrecision precision) {
  writeImage(image, result.image, precision);
  const std::filesystem::path png = std::filesystem::path(image).replace_extension(".png");
  if (command_.pngToo && png != image) writeImage(png.string(), result.image);
}

/// Of a render that fails: what was finished is worth keeping. The failure is told afterwards.
void RenderRun::rescueImage(const Film::Settings& film, const RenderResult& soFar) {
  try {
    writeOutput(film.filename, soFar, film.precision);
    say(fmt::format("failed after {} samples per pixel; wrote what was finished to {}",
                    soFar.samples, film.filename));
  } catch (const std::exception& error) {
    say(fmt::format("the image so far is lost: {}", error.what()));
  }
}

void RenderRun::render(RenderJob& job, FrameReport report) {
  const Film::Settings& film = job.film().settings();
  checkOutput(film.filename);
  for (const std::string& file : job.outputs()) noteOutput(file);

  // Render; from here on a signal ends the render, not the process.
  const StopOnSignal signals;
  log_.verbose(fmt::format("rendering {} with {} threads", film.filename, threadCount()));
  const RenderResult result = [&] {
    ProgressLine line(command_.log.verbosity);
    const auto show = [&](const RenderProgress& p) { line.show(p); };
    const auto rescue = [&](const RenderResult& soFar) { rescueImage(film, soFar); };
    if (!job.isProgressive()) return job.run(signals.stop(), show, {}, rescue);
    // Whoever waits can look: the file is replaced by better ones, each whole.
    double nextRefresh = kSecondsToFirstImage;
    const auto refresh = [&](const RenderResult& soFar) {
      if (soFar.seconds < nextRefresh) return;
      writeOutput(film.filename, soFar, film.precision);
      returnFreeMemory();
      nextRefresh = kSnapshotGrowth * soFar.seconds;
    };
    return job.run(signals.stop(), show, refresh, rescue);
  }();
  Stopwatch watch;
  writeOutput(film.filename, result, film.precision);

  // Report.
  report.image = film.filename;
  report.resolution = film.resolution;
  report.crop = film.crop;
  report.seed = command_.settings.seed;
  report.threads = threadCount();
  report.passes = result.passes;
  report.warnings = log_.warningCount();
  report.reason = result.reason;
  report.seconds.render = result.seconds;
  report.seconds.write = watch.lap();
  report.peakMemory = peakMemory();
  report.acceleratorMemory = job.scene().accelerator().memoryBytes();
  report.acceleratorPeak = job.scene().accelerator().peakMemoryBytes();
  report.stats = result.stats;
  report.files = job.files();
  report.plugins = job.plugins();
  report.plan = job.plan();
  const bool isInterrupted = result.reason == StopReason::Interrupted;
  const bool isBlack = result.passes == 0 && result.stats[Stat::CameraRays] == 0;
  say(fmt::format("{} {} ({} x {}, {})",
                  !isInterrupted ? "wrote"
                  : isBlack      ? "interrupted before the first pass was done; wrote a black"
                                 : "interrupted; wrote",
                  film.filename, film.crop.width(), film.crop.height(),
                  durationText(result.seconds)));
  log_.verbose(statsTable(report));
  reports_.push_back(std::move(report));
  if (!command_.statsFile.empty()) writeTextFile(command_.statsFile, statsJson(reports_));
  if (isInterrupted) throw Interrupted{};
  warnAboutFaults(result.stats);
  if (film.precision == PixelPrecision::Half && film.filename.ends_with(".exr"))
    warnOfHalves(film.filename, result.image);
}

/// What the image file cannot hold.
void RenderRun::warnOfHalves(const std::string& name, const LayeredImage& image) {
  const HalfLoss loss = lossAsHalves(image);
  constexpr const char* kRemedy = "\"string precision\" \"float\" in the Film keeps them";
  if (loss.tooBright > 0)
    log_.warning({}, fmt::format("{} pixels of '{}' are brighter than {}, the largest half, and "
                                 "stored as that; {}",
                                 loss.tooBright, name, kLargestHalf, kRemedy));
  if (loss.isTooDark)
    log_.warning({}, fmt::format("all values of '{}' are so small that halves lose digits of them, "
                                 "or all; {}",
                                 name, kRemedy));
}

void RenderRun::warnAboutFaults(const Stats& stats) {
  for (const auto& [stat, what] : {std::pair{Stat::NanRadiance, "not a number (taken as black)"},
                                   std::pair{Stat::InfiniteRadiance, "infinite (taken as black)"},
                                   std::pair{Stat::NegativeRadiance, "negative"}})
    if (stats[stat] > 0)
      log_.warning({}, fmt::format("the radiance of {} camera rays was {}", stats[stat], what));
}

}  // namespace

int runRender(const RenderCommand& command) { return RenderRun(command).run(); }

}  // namespace brume
