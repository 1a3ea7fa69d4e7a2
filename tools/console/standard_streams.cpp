#include "tools/console/standard_streams.h"

#include "core/io/error.h"
#include "core/io/output_file.h"
#include "scene/formats/model_formats.h"
#include "tools/console/messages.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;

/// Copies the rest of the standard input to a file. Returns false if reading fails.
bool copy_input(std::vector<char>& piece, std::ostream& to) {
  for (std::size_t count = 0; (count = std::fread(piece.data(), 1, piece.size(), stdin)) > 0;)
    to.write(piece.data(), static_cast<std::streamsize>(count));
  return std::ferror(stdin) == 0;
}

/// Copies a file to the standard output. Returns false if reading or writing fails.
bool copy_to_output(const fs::path& file) {
  std::ifstream from(file, std::ios::binary);
  std::vector<char> piece(kPiece);
  while (from) {
    from.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    const auto count = static_cast<std::size_t>(from.gcount());
    if (std::fwrite(piece.data(), 1, count, stdout) != count) return false;
  }
  return from.eof() && std::fflush(stdout) == 0;
}

}  // namespace

std::string scene_extension(std::string_view bytes) {
  if (bytes.starts_with("\xef\xbb\xbf")) bytes.remove_prefix(3);  // byte order mark
  if (bytes.starts_with("\x1f\x8b")) return ".pbrt.gz";
  if (const ModelFormat* const model = detect_model_format(bytes)) return std::string(model->known.extensions[0]);
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  return first == bytes.npos || bytes[first] == '<' ? ".xml" : ".pbrt";
}

StandardStreams::~StandardStreams() {
  std::error_code error;
  if (!folder_.empty()) fs::remove_all(folder_, error);
}

const fs::path& StandardStreams::folder() {
  if (!folder_.empty()) return folder_;
  std::error_code error;
  std::string name = (fs::temp_directory_path(error) / "sheaf-XXXXXX").string();
  if (error || mkdtemp(name.data()) == nullptr)
    throw Error(ExitCode::kRuntime, "cannot create a temporary folder: " + std::string(std::strerror(errno)));
  folder_ = name;
  return folder_;
}

std::string StandardStreams::read_scene(const std::string& scene) {
  if (scene != "-") return scene;
  // Name the copy by its content
  std::vector<char> piece(kPiece);
  const std::size_t count = std::fread(piece.data(), 1, piece.size(), stdin);
  const fs::path copy = folder() / ("stdin" + scene_extension({piece.data(), count}));
  OutputFile file(copy);
  file.stream().write(piece.data(), static_cast<std::streamsize>(count));
  // Copy the rest
  if (!copy_input(piece, file.stream()))
    throw Error(ExitCode::kRuntime,
                "cannot read the scene from the standard input: " + std::string(std::strerror(errno)));
  file.commit();
  replace_in_messages(copy.string(), "standard input");
  has_scene_ = true;
  return copy.string();
}

void StandardStreams::open_output(std::vector<std::string>& outputs, const std::string& format) {
  if (std::find(outputs.begin(), outputs.end(), "-") == outputs.end()) return;
  if (isatty(STDOUT_FILENO) != 0)
    throw Error(ExitCode::kUsage, "-o - would write an image to the terminal: redirect the standard output to a file");
  output_ = folder() / ("stdout." + format);
  replace_in_messages(output_.string(), "standard output");
  std::replace(outputs.begin(), outputs.end(), std::string("-"), output_.string());
}

bool StandardStreams::send_output() {
  std::error_code error;
  if (output_.empty() || !fs::exists(output_, error)) return true;
  errno = 0;
  if (copy_to_output(output_)) return true;
  print_message("cannot write the image to the standard output: " + std::string(std::strerror(errno)));
  return false;
}

}  // namespace sheaf
