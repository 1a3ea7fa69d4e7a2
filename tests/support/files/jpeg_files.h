// Makes JPEG files of kinds that Sheaf reads but does not write, by libjpeg.
#pragma once

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <jpeglib.h>

namespace sheaf::test {

/// What a JPEG file holds, and how.
struct JpegSample {
  int width = 1, height = 1;
  J_COLOR_SPACE given = JCS_RGB, stored = JCS_YCbCr;
  int channels = 3;
  std::vector<unsigned char> values;  ///< interleaved, row by row from the top
  int quality = 100;
  int sampling = 1;  ///< of the first channel, both ways
  bool progressive = false;
  bool adobe_marker = false;
};

inline std::string jpeg_file(const JpegSample& sample) {
  jpeg_compress_struct info{};
  jpeg_error_mgr errors{};
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &bytes, &size);
  info.image_width = static_cast<JDIMENSION>(sample.width);
  info.image_height = static_cast<JDIMENSION>(sample.height);
  info.input_components = sample.channels;
  info.in_color_space = sample.given;
  jpeg_set_defaults(&info);
  jpeg_set_colorspace(&info, sample.stored);
  jpeg_set_quality(&info, sample.quality, TRUE);
  info.write_Adobe_marker = sample.adobe_marker ? TRUE : FALSE;
  info.comp_info[0].h_samp_factor = info.comp_info[0].v_samp_factor = sample.sampling;
  if (sample.progressive) jpeg_simple_progression(&info);
  jpeg_start_compress(&info, TRUE);
  std::vector<unsigned char> values = sample.values;
  const std::size_t row_size = static_cast<std::size_t>(sample.width) * static_cast<std::size_t>(sample.channels);
  while (info.next_scanline < info.image_height) {
    JSAMPROW row = &values[info.next_scanline * row_size];
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  const std::string file(reinterpret_cast<const char*>(bytes), size);
  std::free(bytes);
  return file;
}

}  // namespace sheaf::test
