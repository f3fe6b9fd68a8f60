# cmake -DPAGES=FOLDER -DSCDOC=PROGRAM -P man_pages.cmake: NAME.1.scd -> NAME.1.gz, the same bytes each
# time
file(GLOB sources ${PAGES}/*.scd)
foreach(source ${sources})
  string(REGEX REPLACE "\\.scd$" "" page ${source})
  execute_process(COMMAND ${SCDOC} INPUT_FILE ${source} OUTPUT_FILE ${page} RESULT_VARIABLE failed ERROR_VARIABLE why)
  if(failed)
    message(FATAL_ERROR "${source}: ${why}")
  endif()
  execute_process(COMMAND gzip -9nf ${page} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
