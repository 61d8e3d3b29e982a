# Warnings, optimisation and sanitizers of our own targets: link to lanc_compile.
add_library(lanc_compile INTERFACE)
target_include_directories(lanc_compile INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(lanc_compile INTERFACE -Wall -Wextra -Wno-missing-field-initializers)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # g++ 12 takes undefined lanes of the AVX-512 intrinsics inside Eigen for uninitialised variables.
  target_compile_options(lanc_compile INTERFACE -Wno-maybe-uninitialized -Wno-uninitialized)
  # And it sees strings written beyond their ends where they are moved, in headers that were precompiled.
  target_compile_options(lanc_compile INTERFACE -Wno-array-bounds -Wno-stringop-overread -Wno-stringop-overflow)
  # Straight-line vectorisation of 3-vectors reads by wide loads what was just written by narrow stores, and waits for
  # it: about 5 % of a solve on Zen 4.
  target_compile_options(lanc_compile INTERFACE -fno-tree-slp-vectorize)
  # Room for alignment is room in the cache of decoded instructions, which one small loop fills. Its time
  # was 0.98 on the mean of eight places of the code, among which it varies by as much as 7 %; elsewhere nothing changed.
  target_compile_options(lanc_compile INTERFACE -fno-align-functions -fno-align-loops -fno-align-jumps -fno-align-labels)
endif()
# A call inside the library needs no detour through the dynamic linker.
target_compile_options(lanc_compile INTERFACE -fno-semantic-interposition)
target_compile_options(lanc_compile INTERFACE -fno-math-errno)
if(LANC_NATIVE)
  target_compile_options(lanc_compile INTERFACE -march=native)
endif()
if(LANC_SANITIZE)
  target_compile_options(lanc_compile INTERFACE -fsanitize=${LANC_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(lanc_compile INTERFACE -fsanitize=${LANC_SANITIZE})
endif()
