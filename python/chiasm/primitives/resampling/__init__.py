"""Reading images and volumes between their pixels."""
