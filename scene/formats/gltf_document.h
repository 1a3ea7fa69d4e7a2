// The JSON document of a glTF file and its bytes, before their meaning is known.
#pragma once

#include "scene/formats/gltf.h"

#include <nlohmann/json_fwd.hpp>

#include <memory>

namespace sheaf {

/// The parts of a .gltf or .glb file.
struct GltfDocument {
  GltfDocument();
  GltfDocument(GltfDocument&&) noexcept;
  ~GltfDocument();

  std::unique_ptr<nlohmann::json> json;  ///< an object
  std::vector<std::uint8_t> chunk;       ///< binary chunk of a .glb file; may be empty
};

/// Splits `out.file` into its parts and parses the JSON. Models of other programs are imported (model_import.h). Adds
/// notes. Throws SceneError, with the line for malformed JSON.
GltfDocument read_gltf_document(GltfFile& out);

/// Loads the buffers, and finds the images, of a document; then replaces both in the JSON by short placeholders, so
/// that the library that parses it has no bytes to read. Adds external files to `out.files`. Throws SceneError.
void take_bytes(GltfDocument& document, GltfFile& out);

/// Extension of primitives that adapt_document() adds. Its member "accessor" replaces the primitive's indices.
inline constexpr const char* kIndicesWithoutView = "SHEAF_indices_without_view";

/// Changes what the library rejects although it is valid; adds notes on what is ignored.
void adapt_document(nlohmann::json& document, GltfFile& out);

/// Decodes base 64 (RFC 4648); empty if the text is malformed.
std::vector<std::uint8_t> decode_base64(const std::string& text);

}  // namespace sheaf
