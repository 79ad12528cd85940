#pragma once
/// JPEG to 8-bit gray, whole or not at all. A JPEG has no check sum, but where its data is damaged the decoder sooner
/// or later runs out of step: it meets a code that is none, or has too little or too much left at the end. Libjpeg
/// calls these warnings and fills the rest with what it has; here they are failures.

#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <string_view>

#include <jpeglib.h>

#include <jerror.h>  // after jpeglib.h, which it needs
#include <opencv2/core/mat.hpp>

namespace plumbline::opencv {

namespace detail {

struct JpegErrors {
  jpeg_error_mgr base;  // first: libjpeg hands out its address
  std::jmp_buf escape;
  bool in_picture = false;  // what comes before is about colors and comments

  [[noreturn]] static void fail(j_common_ptr jpeg) {
    std::longjmp(reinterpret_cast<JpegErrors*>(jpeg->err)->escape, 1);
  }
  static void on_message(j_common_ptr jpeg, int level) {
    constexpr int padding = 4;  // bytes that some cameras leave before the end
    const jpeg_error_mgr& error = *jpeg->err;
    const bool is_padding = error.msg_code == JWRN_EXTRANEOUS_DATA && error.msg_parm.i[0] <= padding;
    const bool is_warning = level < 0;
    if (is_warning && reinterpret_cast<JpegErrors*>(jpeg->err)->in_picture && !is_padding) fail(jpeg);
  }
};

}  // namespace detail

/// False, and `gray` of no use, where the bytes are no JPEG or are damaged.
inline bool decode_jpeg(std::string_view bytes, cv::Mat& gray) {
  constexpr std::size_t most_pixels = std::size_t{1} << 28;
  jpeg_decompress_struct jpeg{};
  detail::JpegErrors errors{};
  jpeg.err = jpeg_std_error(&errors.base);
  errors.base.error_exit = detail::JpegErrors::fail;
  errors.base.emit_message = detail::JpegErrors::on_message;
  if (setjmp(errors.escape) != 0) {  // libjpeg's way out; nothing here needs a destructor
    jpeg_destroy_decompress(&jpeg);
    return false;
  }
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<unsigned long>(bytes.size()));
  jpeg_read_header(&jpeg, TRUE);
  if (std::size_t{jpeg.image_width} * jpeg.image_height > most_pixels) errors.base.error_exit(j_common_ptr(&jpeg));
  jpeg.out_color_space = JCS_GRAYSCALE;
  errors.in_picture = true;
  jpeg_start_decompress(&jpeg);
  gray.create(static_cast<int>(jpeg.output_height), static_cast<int>(jpeg.output_width), CV_8U);
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = gray.ptr(static_cast<int>(jpeg.output_scanline));
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  jpeg_destroy_decompress(&jpeg);
  return true;
}

}  // namespace plumbline::opencv
