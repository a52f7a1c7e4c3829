// SPDX-License-Identifier: Apache-2.0
// The entry points of the scene language.
#include <fmt/format.h>

#include <filesystem>

#include "core/parse/parser.h"
#include "core/parse/scene_description.h"

namespace brume {

namespace {

/// One builder that is fed with one or more sources.
class Session {
 public:
  Session(const ParseSettings& settings, Log& log, const Parser::OnFrame& onFrame)
      : builder_(settings, log), log_(log), onFrame_([this, &onFrame](SceneDescription frame) {
          ++frames_;
          onFrame(std::move(frame));
        }) {}

  void read(SourceFile file, const std::string& searchDirectory) {
    builder_.setSearchDirectory(searchDirectory);
    TokenStream tokens(std::move(file), searchDirectory);
    end_ = Parser(tokens, builder_, log_, onFrame_).run();
  }
  void finish() const {
    if (builder_.isInWorld())
      throw SceneError(end_, fmt::format("the file ends before WorldEnd (WorldBegin is at {})",
                                         toString(builder_.worldBeganAt())));
    if (frames_ == 0)
      throw SceneError(end_, "the file ends without WorldBegin: it describes no scene");
  }

 private:
  SceneBuilder builder_;
  Log& log_;
  Parser::OnFrame onFrame_;
  int frames_ = 0;
  SourceLocation end_;
};

void readFile(Session& session, const std::string& path) {
  if (path == "-") {
    session.read(SourceFile(InputFile::standardInput(), internFileName("<stdin>")), "");
    return;
  }
  InputFile bytes = InputFile::open(path, InputFile::Accept::Streams, SourceLocation{});
  session.read(SourceFile(std::move(bytes), internFileName(path)),
               std::filesystem::path(path).parent_path().string());
}

}  // namespace

void parseSceneFile(const std::string& path, const ParseSettings& settings, Log& log,
                    const std::function<void(SceneDescription)>& onFrame) {
  parseSceneFiles({&path, 1}, settings, log, onFrame);
}

void parseSceneFiles(std::span<const std::string> paths, const ParseSettings& settings, Log& log,
                     const std::function<void(SceneDescription)>& onFrame) {
  Session session(settings, log, onFrame);
  for (const std::string& path : paths) readFile(session, path);
  session.finish();
}

void parseSceneText(std::string_view text, const std::string& name,
                    const std::string& searchDirectory, const ParseSettings& settings, Log& log,
                    const std::function<void(SceneDescription)>& onFrame) {
  Session session(settings, log, onFrame);
  session.read(SourceFile(InputFile::borrow(text), internFileName(name)), searchDirectory);
  session.finish();
}

}  // namespace brume
