# Interface target with the flags of our own targets (never handed on to consumers).
add_library(altiro3D_warnings INTERFACE)
target_compile_options(altiro3D_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  $<$<BOOL:${ALTIRO3D_WARNINGS_AS_ERRORS}>:-Werror>
  -fmacro-prefix-map=${PROJECT_SOURCE_DIR}/= # no folder of the builder's in what is installed
  # Equal inputs give equal bytes on every compiler: no fused multiply-add behind our back.
  -ffp-contract=off)
if(ALTIRO3D_SANITIZE)
  target_compile_options(altiro3D_warnings INTERFACE
    -fsanitize=${ALTIRO3D_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>) # GCC is mistaken about the standard library's code with sanitizers
  target_link_options(altiro3D_warnings INTERFACE -fsanitize=${ALTIRO3D_SANITIZE})
endif()
# Tests call functions for what they throw, without a use for the result. Their code may be without the
# sanitizers of the library, as in the preset units.
add_library(altiro3D_test_warnings INTERFACE)
target_compile_options(altiro3D_test_warnings INTERFACE -Wno-unused-result
  $<$<NOT:$<BOOL:${ALTIRO3D_SANITIZE_TESTS}>>:-fno-sanitize=all>)
