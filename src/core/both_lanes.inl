// SPDX-License-Identifier: Apache-2.0
// Includes the kernels in the file BRUME_KERNELS once for each kind of Lanes (lanes.h): namespaces
// generic and avx2, which are the same where there is no AVX2. For a .cpp, inside of its namespace:
//   #define BRUME_KERNELS "transport/kernels_of_mine.inl"
//   #include "core/both_lanes.inl"

namespace generic {
using namespace lanes_generic;
#define BRUME_KERNEL
#include BRUME_KERNELS
#undef BRUME_KERNEL
}  // namespace generic

#if BRUME_HAS_AVX2
namespace avx2 {
using namespace lanes_avx2;
#define BRUME_KERNEL BRUME_AVX2
#include BRUME_KERNELS
#undef BRUME_KERNEL
}  // namespace avx2
#else
namespace avx2 = generic;
#endif

#undef BRUME_KERNELS
