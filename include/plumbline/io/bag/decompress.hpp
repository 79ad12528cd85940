#pragma once
/// Chunks of bags, compressed by bzip2, LZ4 or Zstandard, decompressed piece by piece: memory grows with the bytes that
/// are there, not with the size that a damaged header states.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include "plumbline/io/bag/bag_file.hpp"

namespace plumbline::io::bag {

enum class Compression : std::uint8_t { none, bz2, lz4, zstd };

/// Throws Damage at `offset_bytes` where the name is none that is read.
inline Compression compression_named(std::string_view name, std::uint64_t offset_bytes) {
  if (name.empty() || name == "none") return Compression::none;
  if (name == "bz2") return Compression::bz2;
  if (name == "lz4") return Compression::lz4;
  if (name == "zstd") return Compression::zstd;
  throw Damage(offset_bytes, "a chunk is compressed in a way that is not read; read are none, bz2, lz4 and zstd");
}

namespace detail {

/// What one step of a decoder took and gave.
struct DecoderStep {
  std::size_t taken = 0, given = 0;
  bool is_end = false;
};

class CopyDecoder {
 public:
  DecoderStep step(Bytes in, std::uint8_t* out, std::size_t room) {
    const std::size_t n = std::min(in.size(), room);
    std::copy_n(in.begin(), n, out);
    return {n, n, false};
  }
};

class Bz2Decoder {
 public:
  Bz2Decoder() {
    if (BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK) throw std::bad_alloc();
  }
  Bz2Decoder(const Bz2Decoder&) = delete;
  Bz2Decoder& operator=(const Bz2Decoder&) = delete;
  ~Bz2Decoder() { BZ2_bzDecompressEnd(&stream_); }
  DecoderStep step(Bytes in, std::uint8_t* out, std::size_t room) {
    stream_.next_in = reinterpret_cast<char*>(const_cast<std::uint8_t*>(in.data()));
    stream_.avail_in = static_cast<unsigned>(in.size());
    stream_.next_out = reinterpret_cast<char*>(out);
    stream_.avail_out = static_cast<unsigned>(room);
    const int status = BZ2_bzDecompress(&stream_);
    if (status != BZ_OK && status != BZ_STREAM_END) throw std::runtime_error("bzip2 refuses it");
    return {in.size() - stream_.avail_in, room - stream_.avail_out, status == BZ_STREAM_END};
  }

 private:
  bz_stream stream_{};
};

class Lz4Decoder {
 public:
  Lz4Decoder() {
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context_, LZ4F_VERSION))) throw std::bad_alloc();
  }
  Lz4Decoder(const Lz4Decoder&) = delete;
  Lz4Decoder& operator=(const Lz4Decoder&) = delete;
  ~Lz4Decoder() { LZ4F_freeDecompressionContext(context_); }
  DecoderStep step(Bytes in, std::uint8_t* out, std::size_t room) {
    std::size_t given = room, taken = in.size();
    const std::size_t status = LZ4F_decompress(context_, out, &given, in.data(), &taken, nullptr);
    if (LZ4F_isError(status)) throw std::runtime_error(std::string("LZ4 refuses it: ") + LZ4F_getErrorName(status));
    return {taken, given, status == 0};
  }

 private:
  LZ4F_dctx* context_ = nullptr;
};

class ZstdDecoder {
 public:
  /// A window is no longer than the chunk needs, or 8 MiB, the most of a usual level of compression.
  explicit ZstdDecoder(std::uint64_t chunk_size) : context_(ZSTD_createDCtx()) {
    if (context_ == nullptr) throw std::bad_alloc();
    ZSTD_DCtx_setParameter(context_, ZSTD_d_windowLogMax,
                           std::clamp(static_cast<int>(std::bit_width(chunk_size)), 23, 27));
  }
  ZstdDecoder(const ZstdDecoder&) = delete;
  ZstdDecoder& operator=(const ZstdDecoder&) = delete;
  ~ZstdDecoder() { ZSTD_freeDCtx(context_); }
  DecoderStep step(Bytes in, std::uint8_t* out, std::size_t room) {
    ZSTD_inBuffer from{in.data(), in.size(), 0};
    ZSTD_outBuffer to{out, room, 0};
    const std::size_t status = ZSTD_decompressStream(context_, &to, &from);
    if (ZSTD_isError(status))
      throw std::runtime_error(std::string("Zstandard refuses it: ") + ZSTD_getErrorName(status));
    return {from.pos, to.pos, status == 0};
  }

 private:
  ZSTD_DCtx* context_;
};

}  // namespace detail

/// Compressed bytes in a file.
struct Chunk {
  std::uint64_t offset = 0, stored_size = 0, size = 0;  ///< `size` of the decompressed bytes
  Compression compression = Compression::none;
};

/// Fills `out`. Throws Damage where the chunk is refused by its decoder, or has another size than stated. Of a chunk
/// that the end of the file cuts off, what comes before is kept.
inline void decompress(BagFile& file, const Chunk& chunk, std::vector<std::uint8_t>& out) {
  constexpr std::uint64_t largest = std::uint64_t{1} << 30;
  if (chunk.size > largest) throw Damage(chunk.offset, "a chunk states a size of more than 1 GiB");
  out.clear();
  const auto run = [&](auto&& decoder) {
    std::vector<std::uint8_t> in;
    const std::uint64_t stored = std::min(chunk.stored_size, file.left_from(chunk.offset));
    bool is_end = false;
    for (std::uint64_t at = 0; at < stored && !is_end;) {
      constexpr std::uint64_t piece = 1 << 15;
      file.read(chunk.offset + at, in, std::min(piece, stored - at));
      at += in.size();
      for (Bytes rest(in); !is_end;) {
        const std::size_t before = out.size();
        const std::size_t room = static_cast<std::size_t>(std::min<std::uint64_t>(chunk.size - before + 1, 1 << 18));
        out.resize(before + room);  // one byte more than stated, so that a longer chunk is seen
        const detail::DecoderStep step = decoder.step(rest, out.data() + before, room);
        out.resize(before + step.given);
        if (out.size() > chunk.size) throw std::runtime_error("it is longer than stated");
        rest = rest.subspan(step.taken);
        is_end = step.is_end;
        if (step.taken == 0 && step.given == 0) break;
        if (rest.empty() && step.given < room) break;
      }
    }
  };
  try {
    switch (chunk.compression) {
      case Compression::none: run(detail::CopyDecoder()); break;
      case Compression::bz2: run(detail::Bz2Decoder()); break;
      case Compression::lz4: run(detail::Lz4Decoder()); break;
      case Compression::zstd: run(detail::ZstdDecoder(chunk.size)); break;
    }
  } catch (const Damage&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw Damage(chunk.offset, std::string("a chunk is damaged: ") + error.what());
  }
  const bool is_cut = chunk.stored_size > file.left_from(chunk.offset);
  if (out.size() < chunk.size && !is_cut) throw Damage(chunk.offset, "a chunk is damaged: it is shorter than stated");
}

}  // namespace plumbline::io::bag
