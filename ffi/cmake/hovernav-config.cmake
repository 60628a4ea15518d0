# hovernav::hovernav is the shared library, hovernav::static the static one.
#
#     find_package(hovernav 0.1 REQUIRED)
#     target_link_libraries(flight_computer PRIVATE hovernav::hovernav)

get_filename_component(_hovernav_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

foreach(_hovernav_kind shared static)
    if(_hovernav_kind STREQUAL "shared")
        set(_hovernav_target hovernav::hovernav)
        set(_hovernav_type SHARED)
        set(_hovernav_file ${CMAKE_SHARED_LIBRARY_PREFIX}hovernav_c${CMAKE_SHARED_LIBRARY_SUFFIX})
    else()
        set(_hovernav_target hovernav::static)
        set(_hovernav_type STATIC)
        set(_hovernav_file ${CMAKE_STATIC_LIBRARY_PREFIX}hovernav_c${CMAKE_STATIC_LIBRARY_SUFFIX})
    endif()
    set(_hovernav_path "${_hovernav_prefix}/lib/${_hovernav_file}")
    if(EXISTS "${_hovernav_path}" AND NOT TARGET ${_hovernav_target})
        add_library(${_hovernav_target} ${_hovernav_type} IMPORTED)
        set_target_properties(${_hovernav_target} PROPERTIES
            IMPORTED_LOCATION "${_hovernav_path}"
            IMPORTED_NO_SONAME TRUE
            INTERFACE_INCLUDE_DIRECTORIES "${_hovernav_prefix}/include")
    endif()
endforeach()

if(TARGET hovernav::static)
    set_property(TARGET hovernav::static PROPERTY
        INTERFACE_LINK_LIBRARIES ${CMAKE_DL_LIBS} pthread m)
endif()
if(NOT TARGET hovernav::hovernav)
    set(hovernav_FOUND FALSE)
    set(hovernav_NOT_FOUND_MESSAGE "no ${_hovernav_prefix}/lib/libhovernav_c of this system")
endif()

unset(_hovernav_prefix)
unset(_hovernav_kind)
unset(_hovernav_target)
unset(_hovernav_type)
unset(_hovernav_file)
unset(_hovernav_path)
