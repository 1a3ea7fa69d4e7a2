// Functions shared by the readers of mesh files.
#include "scene/formats/mesh_io.h"

#include "core/io/byte_order_mark.h"
#include "core/io/file_cache.h"
#include "core/io/inflate.h"
#include "core/soa/large_pages.h"
#include "scene/formats/model_formats.h"

#include <algorithm>
#include <fstream>
#include <system_error>

namespace sheaf {

namespace {

/// Decompresses a gzip file.
std::string inflated(std::string_view bytes, const SourceLocation& where, std::string_view what) {
  constexpr std::size_t kPiece = std::size_t{1} << 20, kMax = std::size_t{1} << 32;
  if (!bytes.starts_with("\x1f\x8b"))
    throw SceneError(where, std::string(what) + " is not a gzip file, despite its extension");
  Inflater inflater(bytes);
  std::string out;
  try {
    for (std::size_t found = kPiece; found == kPiece;) {
      const std::size_t size = out.size();
      if (size > kMax) throw SceneError(where, std::string(what) + " takes more than 4 GiB uncompressed");
      out.resize(size + kPiece);
      found = inflater.read(std::span(out).subspan(size));
      out.resize(size + found);
    }
  } catch (const SceneError&) { throw; } catch (const Error& error) {
    throw SceneError(where, fmt::format("{}: {}", what, error.what()));
  }
  if (inflater.max_remaining() != 0) throw SceneError(where, std::string(what) + " is truncated");
  return out;
}

/// Size of a regular file. Throws SceneError if it cannot be opened.
std::size_t checked_size(const std::filesystem::path& file, std::string_view what) {
  const SourceLocation where{file.string()};
  std::error_code failure;
  const auto status = std::filesystem::status(file, failure);
  if (!std::filesystem::exists(status)) throw SceneError(where, std::string(what) + " not found");
  if (!std::filesystem::is_regular_file(status)) {
    throw SceneError(where, std::string(what) + " is not a regular file");
  }
  const std::uintmax_t size = std::filesystem::file_size(file, failure);
  std::ifstream stream(file, std::ios::binary);
  if (failure || !stream) throw SceneError(where, std::string(what) + " cannot be opened for reading");
  return size;
}

}  // namespace

std::string read_mesh_bytes(const std::filesystem::path& file, std::string_view what) {
  const SourceLocation where{file.string()};
  const std::size_t size = checked_size(file, what);
  std::ifstream stream(file, std::ios::binary);
  std::string bytes;
  bytes.reserve(size + 1);  // for the line feed that text readers append
  prepare_pages(bytes.data(), size);
  bytes.resize(size);
  stream.read(bytes.data(), static_cast<std::streamsize>(size));
  if (stream.gcount() != static_cast<std::streamsize>(size))
    throw SceneError(where, std::string(what) + " cannot be read to its end");
  if (file.extension() == ".gz") return inflated(bytes, where, what);
  return bytes;
}

std::string read_mesh_text(const std::filesystem::path& file, std::string_view what) {
  std::string text = read_mesh_bytes(file, what);
  remove_byte_order_mark(text, file.string());
  return text;
}

MeshTextFile::MeshTextFile(std::filesystem::path file, std::string_view what) : file_(std::move(file)), what_(what) {
  if (file_.extension() == ".gz") {
    decompressed_ = read_mesh_text(file_, what);
    end_ = decompressed_.size();
    return;
  }
  end_ = checked_size(file_, what);
  constexpr std::size_t kLongestMark = 4;
  std::string mark(std::min(end_, kLongestMark), '\0');
  read(0, mark);
  const std::size_t size = mark.size();
  remove_byte_order_mark(mark, file_.string());
  begin_ = size - mark.size();
}

void MeshTextFile::read(std::size_t position, std::span<char> out) const {
  if (file_.extension() == ".gz") {
    std::copy_n(decompressed_.begin() + static_cast<std::ptrdiff_t>(position), out.size(), out.begin());
    return;
  }
  std::ifstream stream(file_, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(position));
  stream.read(out.data(), static_cast<std::streamsize>(out.size()));
  if (!stream || stream.gcount() != static_cast<std::streamsize>(out.size()))
    throw SceneError(SourceLocation{file_.string()}, what_ + " cannot be read to its end");
}

double mesh_reading_bytes(const MeshFileShape& shape) {
  constexpr double kPlain = 5;          // text or binary numbers, lists of corners, and the mesh
  constexpr double kCompressed = 1030;  // the highest ratio of deflate
  std::error_code failure;
  const std::uintmax_t size = std::filesystem::file_size(shape.file, failure);
  const bool is_compressed = shape.file.extension() == ".gz" || mesh_format(shape.format).is_compressed;
  return failure ? 0 : (is_compressed ? kCompressed : kPlain) * static_cast<double>(size);
}

MeshFile read_mesh(const MeshFileShape& shape) {
  std::string key = "mesh " + shape.format;
  for (const int option : {int{shape.flip_tex_coords}, shape.shape_index, static_cast<int>(shape.bad_faces)})
    key += fmt::format(" {}", option);
  return cached(shape.file, key, [&] { return mesh_format(shape.format).read(shape); });
}

}  // namespace sheaf
