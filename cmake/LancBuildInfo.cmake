# Version, commit, dirty flag, compiler and flags for the sidecars of experiments (lib/report/sidecar.h).
#
# Included: adds to the target lanc a source file that is brought up to date at every build. Run as a script (cmake -P):
# writes that file, only if something changed, so that an unchanged tree compiles nothing.
if(CMAKE_SCRIPT_MODE_FILE)
  set(LANC_COMMIT "")
  set(LANC_DIRTY false)
  find_program(GIT git)
  if(GIT)
    execute_process(COMMAND ${GIT} -C ${SOURCE} rev-parse HEAD OUTPUT_VARIABLE commit RESULT_VARIABLE failed
                    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(NOT failed)
      set(LANC_COMMIT ${commit})
      execute_process(COMMAND ${GIT} -C ${SOURCE} status --porcelain OUTPUT_VARIABLE changes ERROR_QUIET)
      if(changes)
        set(LANC_DIRTY true)
      endif()
    endif()
  endif()
  configure_file(${SOURCE}/lib/report/build_info.cpp.in ${OUTPUT} @ONLY)  # leaves an equal file untouched
  return()
endif()

set(lanc_build_info ${CMAKE_CURRENT_BINARY_DIR}/generated/lib/report/build_info.cpp)
set(lanc_build_flags ${CMAKE_CURRENT_BINARY_DIR}/generated/lib/report/build_flags.h)
string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type_upper)
set(lanc_flags "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${build_type_upper}} \
$<JOIN:$<TARGET_PROPERTY:lanc_compile,INTERFACE_COMPILE_OPTIONS>, >")
set(sanitized false)
if(LANC_SANITIZE)
  set(sanitized true)
endif()
file(GENERATE OUTPUT ${lanc_build_flags} CONTENT "// Generated.
#pragma once
namespace lanc {
constexpr char build_compiler[] = R\"(${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION})\";
constexpr char build_flags[] = R\"(${lanc_flags})\";
constexpr char build_type[] = R\"(${CMAKE_BUILD_TYPE})\";
constexpr bool build_sanitized = ${sanitized};
}  // namespace lanc
")
add_custom_target(lanc_build_info
  COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -DOUTPUT=${lanc_build_info} -DLANC_VERSION=${PROJECT_VERSION}
          -P ${CMAKE_CURRENT_LIST_DIR}/LancBuildInfo.cmake
  BYPRODUCTS ${lanc_build_info}
  COMMENT "")
add_dependencies(lanc lanc_build_info)
target_sources(lanc PRIVATE ${lanc_build_info})
set_source_files_properties(${lanc_build_info} PROPERTIES INCLUDE_DIRECTORIES ${CMAKE_CURRENT_BINARY_DIR}/generated)
