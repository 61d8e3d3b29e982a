# The CMake package: find_package(lanc), then link to lanc::lanc (examples/own-formulation). Library and headers only: the
# programs have names like "solve", too common for a system's bin. Headers keep their paths: #include "lib/lanc.h".
include(CMakePackageConfigHelpers)

set_target_properties(lanc PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
target_include_directories(lanc PUBLIC $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/lanc>)
install(TARGETS lanc EXPORT lancTargets)
set(lanc_package ${CMAKE_INSTALL_LIBDIR}/cmake/lanc)
install(EXPORT lancTargets NAMESPACE lanc:: DESTINATION ${lanc_package})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/lancConfig.cmake.in ${PROJECT_BINARY_DIR}/lancConfig.cmake
                              INSTALL_DESTINATION ${lanc_package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/lancConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/lancConfig.cmake ${PROJECT_BINARY_DIR}/lancConfigVersion.cmake
        DESTINATION ${lanc_package})

# Headers that include anything but the standard library, Eigen and each other are the library's own affair.
file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/lib/*.h)
foreach(header IN LISTS headers)
  file(STRINGS ${PROJECT_SOURCE_DIR}/${header} private REGEX "^#include <([^E][^>]*[/.]|E[^i])|^// .*Private to ")
  if(NOT private)
    get_filename_component(folder ${header} DIRECTORY)
    install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/lanc/${folder})
  endif()
endforeach()
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
