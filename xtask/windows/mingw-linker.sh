#!/bin/sh
# mingw's gcc in the place of clang: rustc's gnullvm target gives flags that only clang knows.
for flag; do
    shift
    case $flag in
    --unwindlib=none | -nolibc) ;;
    -lunwind) set -- "$@" -lgcc_eh -lgcc ;;
    *) set -- "$@" "$flag" ;;
    esac
done
exec x86_64-w64-mingw32-gcc "$@" -static-libgcc -Wl,--no-insert-timestamp
