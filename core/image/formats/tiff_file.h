// The interface to libtiff: files in memory or on the disk, without messages on the standard error stream. Only the
// files tiff*.cpp include it.
#pragma once

#include <tiffio.h>

#include <cstdarg>
#include <cstdio>
#include <memory>
#include <string>

namespace sheaf {

/// The first error of libtiff since the last clear().
class TiffMessage {
 public:
  const std::string& text() const { return text_; }
  void clear() { text_.clear(); }

  /// A handler of errors; `message` is the object.
  static int keep(TIFF* /*file*/, void* message, const char* /*module*/, const char* format, std::va_list values) {
    std::string& text = static_cast<TiffMessage*>(message)->text_;
    if (!text.empty()) return 1;
    char line[256];
    std::vsnprintf(line, sizeof(line), format, values);
    text = line;
    return 1;
  }
  /// A handler of warnings.
  static int ignore(TIFF* /*file*/, void* /*message*/, const char* /*module*/, const char* /*format*/,
                    std::va_list /*values*/) {
    return 1;
  }

 private:
  std::string text_;
};

using TiffHandle = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

/// Opens a file. File has the static functions read, write, seek and size with `file` as the first parameter. On
/// failure returns null.
template <class File> TiffHandle open_tiff_file(File& file, TiffMessage& message, const char* mode) {
  constexpr tmsize_t kMaxAllocation = tmsize_t{1} << 30;
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(TIFFOpenOptionsAlloc(),
                                                                                 TIFFOpenOptionsFree);
  if (!options) return {nullptr, TIFFClose};
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMaxAllocation);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), TiffMessage::keep, &message);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), TiffMessage::ignore, nullptr);
  const auto close = [](thandle_t) { return 0; };
  return {TIFFClientOpenExt("image", mode, &file, File::read, File::write, File::seek, close, File::size, nullptr,
                            nullptr, options.get()),
          TIFFClose};
}

}  // namespace sheaf
