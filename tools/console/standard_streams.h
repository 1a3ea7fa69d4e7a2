// Scenes from the standard input and images to the standard output, for pipelines. Readers and writers need files, so
// the streams are copied from and to temporary files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sheaf {

/// Owns a temporary folder, which it creates when needed and finally removes. Messages name the streams instead of
/// the files.
class StandardStreams {
 public:
  StandardStreams() = default;
  ~StandardStreams();
  StandardStreams(const StandardStreams&) = delete;
  StandardStreams& operator=(const StandardStreams&) = delete;

  /// If `scene` is "-", copies the standard input to a file and returns its name, whose extension is chosen by the
  /// content; otherwise returns `scene`. Throws Error (exit code 1) if it cannot be copied.
  std::string read_scene(const std::string& scene);
  /// Whether read_scene() copied the standard input. Relative paths of the scene then refer to the working directory.
  bool has_scene() const { return has_scene_; }
  /// Replaces each "-" by the name of a file of this format. Throws Error (exit code 2) if the standard output is a
  /// terminal.
  void open_output(std::vector<std::string>& outputs, const std::string& format);
  /// Copies that file, if there is one, to the standard output. Returns false and prints the error if that fails.
  bool send_output();

 private:
  const std::filesystem::path& folder();

  std::filesystem::path folder_, output_;
  bool has_scene_ = false;
};

/// The file extension for a scene or model of unknown name, by its first bytes: ".xml", ".pbrt", ".ply" ...
std::string scene_extension(std::string_view bytes);

}  // namespace sheaf
