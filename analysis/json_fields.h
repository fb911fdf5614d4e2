// Makes members of a struct entries of a JSON object under their own names, so that each name is written once:
// {JSON_FIELDS(time, p10_s, p50_s), {"runs", runs.size()}}.
#pragma once

#include <boost/preprocessor/punctuation/comma_if.hpp>
#include <boost/preprocessor/seq/for_each_i.hpp>
#include <boost/preprocessor/stringize.hpp>
#include <boost/preprocessor/variadic/to_seq.hpp>

#define TACTBENCH_JSON_FIELD(r, object, i, name) \
  BOOST_PP_COMMA_IF(i) { BOOST_PP_STRINGIZE(name), object.name }
#define JSON_FIELDS(object, ...) \
  BOOST_PP_SEQ_FOR_EACH_I(TACTBENCH_JSON_FIELD, object, BOOST_PP_VARIADIC_TO_SEQ(__VA_ARGS__))
