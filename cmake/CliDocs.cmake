# Runs COMMAND --help for itself and every subcommand, and writes cli.md, man pages and bash completion into OUTPUT.
file(REMOVE_RECURSE ${OUTPUT}/man)
file(MAKE_DIRECTORY ${OUTPUT}/man)

function(help_of name result)
  execute_process(COMMAND ${COMMAND} ${name} --help OUTPUT_VARIABLE text RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "${COMMAND} ${name} --help failed")
  endif()
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

# Escapes a text for a man page: backslashes, hyphens and leading dots and quotes have a meaning in roff.
function(roff text result)
  string(REPLACE "\\" "\\\\" text "${text}")
  string(REPLACE "-" "\\-" text "${text}")
  string(REGEX REPLACE "(^|\n)([.'])" "\\1\\\\&\\2" text "${text}")
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

function(write_man page title summary text see)
  roff("${text}" text)
  roff("${summary}" summary)
  roff("${title}" title)
  string(TOUPPER "${page}" upper)
  file(WRITE ${OUTPUT}/man/${page}.1 ".TH \"${upper}\" 1 \"\" \"trephine ${VERSION}\" \"User Commands\"
.SH NAME
${title} \\- ${summary}
.SH DESCRIPTION
.nf
${text}
.fi
.SH EXIT STATUS
0 done, 1 a check failed, 2 bad input, 3 this machine lacks something, 130 interrupted.
.SH SEE ALSO
${see}
")
endfunction()

# Options of every command; the markdown contains them once.
help_of(info every)
set(common_options "")
foreach(option "-h,--help" "--json" "--keep-identity")
  string(REGEX MATCH "\n(  ${option} [^\n]*)" line "${every}")
  if(NOT CMAKE_MATCH_1)
    message(FATAL_ERROR "trephine info --help has no ${option}")
  endif()
  list(APPEND common_options "${CMAKE_MATCH_1}")
endforeach()

help_of("" top)
string(REGEX MATCH "Subcommands:\n.*\nExamples" list "${top}")
string(REPLACE ";" "," list "${list}")
string(REGEX MATCHALL "\n  [a-z-]+ +[^\n]*" lines "${list}")
set(names "")
set(markdown "# The command line\n\nThe output of `trephine --help` and `trephine COMMAND --help`. Exit codes: 0 done, 1 a check failed, 2 bad input, 3 this machine lacks something, 130 interrupted.\n\nOptions of every command, which are not repeated below:\n\n")
foreach(line IN LISTS common_options)
  string(APPEND markdown "    ${line}\n")
endforeach()
string(APPEND markdown "\n    ")
string(STRIP "${top}" shown)
string(REPLACE "\n" "\n    " shown "${shown}")
string(APPEND markdown "${shown}\n")
set(completion "# bash completion of trephine
_trephine() {
  local current=\${COMP_WORDS[COMP_CWORD]} previous=\${COMP_WORDS[COMP_CWORD-1]} options=\"\"
  case \"$previous\" in
    --path|--case|--labels|--record|--screenshot|--steps|-o|--output) COMPREPLY=($(compgen -f -- \"$current\")); return ;;
  esac
  if [ \"$COMP_CWORD\" -eq 1 ]; then
    COMPREPLY=($(compgen -W \"@NAMES@ --help --version\" -- \"$current\"))
    return
  fi
  case \"\${COMP_WORDS[1]}\" in
")
foreach(line ${lines})
  string(REGEX REPLACE "\n  ([a-z-]+) +([^\n]*)" "\\1" name "${line}")
  string(REGEX REPLACE "\n  ([a-z-]+) +([^\n]*)" "\\2" summary "${line}")
  help_of(${name} text)
  string(STRIP "${text}" text)
  list(APPEND names ${name})
  string(REPLACE "\n" "\n    " shown "${text}")
  foreach(option IN LISTS common_options)
    string(REPLACE "    ${option}\n" "" shown "${shown}")
  endforeach()
  string(REPLACE "Options:\n    \n" "\n" shown "${shown}")
  string(APPEND markdown "\n## trephine ${name}\n\n    ${shown}\n")
  write_man(trephine-${name} "trephine-${name}" "${summary}" "${text}" ".BR trephine (1)")
  string(REGEX MATCHALL "--[a-z][a-z-]*" options "${text}")
  list(REMOVE_DUPLICATES options)
  string(REPLACE ";" " " options "${options}")
  string(APPEND completion "    ${name}) options=\"${options}\" ;;\n")
endforeach()
string(APPEND completion "  esac
  case \"$current\" in
    -*) COMPREPLY=($(compgen -W \"$options\" -- \"$current\")) ;;
    *) COMPREPLY=($(compgen -W head -- \"$current\") $(compgen -f -- \"$current\")) ;;
  esac
}
complete -o filenames -F _trephine trephine
")
string(REPLACE ";" " " spaced "${names}")
string(REPLACE "@NAMES@" "${spaced}" completion "${completion}")
set(see "")
foreach(name ${names})
  string(APPEND see ".BR trephine-${name} (1)\n")
endforeach()
write_man(trephine "trephine" "surgery on real CT and MRI volumes that you can feel" "${top}" "${see}")
# Trailing blanks have a meaning in Markdown.
string(REGEX REPLACE "[ \t]+\n" "\n" markdown "${markdown}")
file(WRITE ${OUTPUT}/trephine.bash "${completion}")
file(WRITE ${OUTPUT}/cli.md "${markdown}")
file(GLOB pages ${OUTPUT}/man/*.1)
execute_process(COMMAND gzip -9nf ${pages} RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "gzip of the man pages failed")
endif()
