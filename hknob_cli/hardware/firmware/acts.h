/* Bodies of what acts in a trial beside the plain wall: controller, pulse, the person who fires it, torque over the angle,
   and converters (acts.c). */
#ifndef ACTS_H
#define ACTS_H

#include "bytes.h"
#include "messages.h"

/* From a body of `count` bytes, of which the nonce was read; false where its length is another. */
bool control_read(struct control *control, struct reader *reader, size_t count);
bool pulse_read(struct pulse *pulse, struct reader *reader, size_t count);
bool over_angle_read(struct over_angle *over_angle, struct reader *reader, size_t count);
bool torques_read(struct torques *torques, struct reader *reader, size_t count);
bool squeeze_read(struct squeeze *squeeze, struct reader *reader, size_t count);
bool converters_read(struct converters *converters, struct reader *reader, size_t count);

/* Sines of a push, a grip or a squeeze: 24 bytes each, whose length was checked. */
void sines_read(struct sine *sines, size_t count, struct reader *reader);
size_t sines_write(uint8_t *body, size_t at, const struct sine *sines, size_t count);

#endif
