// Reading of the Netpbm formats PBM, PGM and PPM, and of PFM ("Portable Float Map").
#pragma once

#include "core/image/image_reader.h"
#include "core/image/image_source.h"

#include <memory>

namespace sheaf {

/// Opens a PBM, PGM or PPM file, as text or binary (P1 to P6). Values above 255 make 16 bits. On failure returns null
/// and sets `problem`.
std::unique_ptr<ImageReader> open_pnm(ImageSource source, std::string& problem);

/// Opens a PFM file (PF, Pf). The values are multiplied by the scale of the header. On failure returns null and sets
/// `problem`.
std::unique_ptr<ImageReader> open_pfm(ImageSource source, std::string& problem);

}  // namespace sheaf
