#pragma once
/// Elementary functions: those of the C++ library, or with PLUMBLINE_REPRODUCIBLE defined those that give the same bits
/// on every machine. All of a program must agree. docs/guide/firmware.md

#ifdef PLUMBLINE_REPRODUCIBLE
#include "plumbline/core/fixed_elementary.hpp"
#else
#include <cmath>
#endif

namespace plumbline {

#ifdef PLUMBLINE_REPRODUCIBLE
namespace elementary = fixed_elementary;
#else
namespace elementary {
using std::acos, std::atan2, std::cbrt, std::cos, std::exp, std::hypot, std::log, std::log1p, std::pow, std::sin,
    std::tan;
}
#endif

}  // namespace plumbline
